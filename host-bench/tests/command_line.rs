//! The command line through the real binary: what it refuses and how, and what a good run prints.

mod command_line {
    mod accuracy;
    mod attractors;
    mod budget;
    mod bump_stop;
    mod closed_form;
    mod created_energy;
    mod export;
    mod figures;
    mod fit;
    mod fit_kinds;
    mod good_runs;
    mod help;
    mod hints;
    mod hostile_names;
    mod interrupted;
    mod keys;
    mod limits;
    mod needs;
    mod optimise;
    mod outputs;
    mod pages;
    mod plot;
    mod presets;
    mod refused_options;
    mod refused_scenes;
    mod refused_spellings;
    mod report;
    mod seeds;
    mod sliding;
    mod statements;
    mod steady_state;
    mod step_errors;
    mod stop;
    mod sweep;
    mod tolerance;
    mod tool;
    mod trace_columns;
    mod traces;
    mod validation;
}
