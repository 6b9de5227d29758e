//! Golden trajectories, closed forms, ledgers and statistics.

mod contact;
mod linear;
mod statistics;
mod storage;

use super::Event;
use crate::ReferenceOptions;
use crate::test_support::{bump_stop, close, number};
use harvester_scene::outcome::{BumpStopOutcome, Outcome, Particular};
use harvester_scene::scene_file::{
    BumpStop, BumpStopParameters, BumpStopStart, Contact, Coupling, Excitation, Load, Model, RunSpan, Scene,
    StopParameters, Tone,
};

/// The beam of the shipped scene.
fn parameters(beam_modes: usize) -> BumpStopParameters {
    BumpStopParameters { beam_modes, ..bump_stop().parameters }
}

/// The stop of the shipped scene.
fn stop(rod_modes: usize) -> StopParameters {
    StopParameters { rod_modes, ..bump_stop().stop.expect("there is a stop") }
}

const FREQUENCY: f64 = 220.0;
const AMPLITUDE: f64 = 20.0;

/// The shipped scene with these modes, at 1 MΩ and shaken with 20 m/s² at 220 Hz, for a span in s.
fn scene([beam_modes, rod_modes]: [usize; 2], [settle_s, duration_s]: [f64; 2]) -> (BumpStop, Scene) {
    let model = BumpStop {
        parameters: parameters(beam_modes),
        stop: Some(stop(rod_modes)),
        initial: BumpStopStart::at_rest(beam_modes, rod_modes),
    };
    let tone = Tone { amplitude_m_per_s2: AMPLITUDE, frequency_hz: FREQUENCY, phase_rad: 0.0 };
    let scene = Scene {
        file: "test.toml".into(),
        model: Model::BumpStop(model.clone()),
        load: Load::Resistor { resistance_ohm: 1e6 },
        excitation: Excitation::Sine(tone),
        run: RunSpan { duration_s, settle_s },
        limits: Vec::new(),
    };
    (model, scene)
}

/// Runs `model` as `scene` says, with rows every `record_every` seconds.
fn run(model: &BumpStop, scene: &Scene, record_every: Option<f64>) -> (Outcome, Vec<Event>) {
    let options = ReferenceOptions { record_every, ..ReferenceOptions::default() };
    let mut events = Vec::new();
    let outcome =
        super::run(scene, model, &options, |event| events.push(*event)).expect("the run gets to its end");
    (outcome, events)
}

fn particular(outcome: &Outcome) -> &BumpStopOutcome {
    match &outcome.particular {
        Particular::BumpStop(found) => found,
        other => panic!("a bump-stop run, not {other:?}"),
    }
}

/// The row recorded at `time`: `time`, tip, stop point, face, voltage, force, base.
fn row(outcome: &Outcome, time: f64) -> &[f64] {
    let rows = &outcome.trace.as_ref().expect("a recording").rows;
    rows.iter().find(|row| (row[0] - time).abs() < 1e-12).expect("a row at that time")
}

/// Digits of an independent computation, event-driven, in the eigenvectors of each state of contact; that
/// one agreed with a Runge-Kutta method of order 8 at a tolerance of 1e-12 to 8e-16 s and 2e-12.
#[test]
fn the_first_contacts_are_those_of_an_independent_computation() {
    let (mut model, scene) = scene([6, 2], [0.0, 6e-3]);
    let (outcome, events) = run(&model, &scene, Some(1e-5));
    let milliseconds = [3.306469272, 3.324689895, 3.344968680, 3.362553037, 3.385140677, 3.401949435];
    assert_eq!(events.len(), 16);
    assert_eq!(particular(&outcome).contacts, 8);
    for (event, expected) in events.iter().zip(milliseconds) {
        assert!((event.time - 1e-3 * expected).abs() <= 0.6e-12, "{event:?} {expected}");
    }
    close(events[0].speed, 0.046_365_446, 2e-8);
    assert_eq!(particular(&outcome).first_contact_s, Some(events[0].time));
    for (time, tip, face, voltage, force) in [
        (1e-3, -5.539_933_047e-6, -1.506_246_795e-10, -0.402_252_778_1, 0.0),
        (3e-3, -3.534_148_929e-6, 1.294_591_137e-10, -0.166_998_651_3, 0.0),
        (3.31e-3, 1.014_466_764e-5, 3.678_122_919e-8, 0.903_882_200_0, 1.145_642),
        (4e-3, 4.661_675_651e-6, -1.255_887_874e-8, 0.869_148_334_1, 0.0),
        (6e-3, -1.509_803_342e-5, -1.396_847_401e-10, -0.701_496_050_4, 0.0),
    ] {
        let row = row(&outcome, time);
        close(row[1], tip, 1e-9);
        assert_eq!(row[1], row[2]);
        close(row[3], face, 1e-9);
        close(row[4], voltage, 1e-9);
        assert!((row[5] - force).abs() <= 1e-6, "{row:?} {force}");
    }
    assert!(number(outcome.energy_residual) < 1e-12);

    model.parameters.coupling = Coupling::OneWay;
    let (outcome, events) = run(&model, &scene, Some(1e-3));
    let milliseconds = [3.333173400, 3.351388587, 3.371875227, 3.389446179, 3.411967571, 3.428764226];
    for (event, expected) in events.iter().zip(milliseconds) {
        assert!((event.time - 1e-3 * expected).abs() <= 0.6e-12, "{event:?} {expected}");
    }
    close(row(&outcome, 6e-3)[4], -0.682_948_187_4, 1e-9);
    close(row(&outcome, 6e-3)[1], -1.644_225_653e-5, 1e-9);
    assert!(number(outcome.energy_residual) < 1e-12);
}
