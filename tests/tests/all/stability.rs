//! A slice of the grids of stiff and extreme scenes, and random scenes over the whole range of the bounds: each is
//! refused, ends in a named error, or gives a mean power that is right or announced as inaccurate.

use cross_crate_tests::on_all_cores;
use host_bench::method::Precision;
use host_bench::stability::{
    Case, Class, Effort, Extent, Finding, Kind, Quantity, draw, draw_varied, grid, judge,
};

const SEED: u64 = 2026;
const COUNT: u64 = 100;
/// Most attempted steps of a run: few, because the tests are unoptimised.
const MOST_ATTEMPTS: u64 = 40_000;

/// Of the grids one case in so many is judged: an odd number, for both precisions.
const OF_GRID: usize = 95;

/// The scenes that were found wrong, with the arguments of `run`.
fn found() -> Vec<Case> {
    vec![
        // In single precision the charge of so small a motion is lost, and nothing is delivered: the statement was 0.
        case(
            "contact-separation",
            "parameters.stick_charge=frozen \
             load={kind='rectified-store',capacitance_f=3.1e-5,initial_v=0.0,diode_drop_v=0.0,leakage_ohm=1.3e4} \
             excitation={kind='sine',amplitude_m_per_s2=0.0168,frequency_hz=34320,phase_rad=-2.577} \
             run={duration_s=4.63e-4,settle_s=1.389e-4}",
            Precision::F32,
        ),
        // A settling mass whose charge no tolerance resolves: half the tolerance took the same steps, and the statement
        // was 0.
        case(
            "contact-separation",
            "parameters.damping_ratio=2.261e-2 parameters.force_law=gap-field \
             parameters.parasitic_capacitance_f=1.413e-11 \
             load={kind='rectified-store',capacitance_f=4.656e-12,initial_v=0.0,diode_drop_v=0.0,leakage_ohm=inf,draw={kind='resistor',value=5021}} \
             excitation={kind='silence'} run={duration_s=0.9444,settle_s=0.0}",
            Precision::F64,
        ),
        // Impacts with a circuit that no step resolves: half the tolerance delivered the same energy, to the last bit.
        case(
            "contact-separation",
            "parameters.mass_kg=6.041e-3 parameters.stiffness_n_per_m=113.4 parameters.initial_gap_m=4.734e-3 \
             parameters.electrode_area_m2=2.555e-4 parameters.dielectric_thickness_m=7.709e-5 \
             parameters.relative_permittivity=1.977 parameters.charge_density_c_per_m2=3.166e-5 \
             parameters.damping_ratio=4.036 \
             parameters.restitution={kind='velocity-dependent',at_rest=0.8031,at_speed=0.6061,reference_speed_m_per_s=0.02724} \
             parameters.parasitic_capacitance_f=1.395e-9 initial.charge_c=4.517e-8 load.resistance_ohm=3.058e-2 \
             excitation={kind='sine',amplitude_m_per_s2=788.9,frequency_hz=9.468,phase_rad=2.776} \
             run={duration_s=1.279,settle_s=0.3838}",
            Precision::F64,
        ),
        // A start charge that is gone within nanoseconds: its force acted throughout the first step.
        case(
            "contact-separation",
            "parameters.mass_kg=4.210e-3 parameters.stiffness_n_per_m=6.012e1 parameters.initial_gap_m=3.879e-3 \
             parameters.electrode_area_m2=2.652e-4 parameters.dielectric_thickness_m=5.942e-5 \
             parameters.relative_permittivity=2.263e0 parameters.charge_density_c_per_m2=7.323e-5 \
             parameters.damping_ratio=1.431e-2 parameters.force_law=transferred-charge \
             parameters.stick_charge=relaxing parameters.restitution={kind='constant',coefficient=1.000e0} \
             parameters.parasitic_capacitance_f=4.841e-9 initial.charge_c=-3.319e-8 load.resistance_ohm=1.928e-1 \
             excitation={kind='sine',amplitude_m_per_s2=6.775e2,frequency_hz=1.662e1,phase_rad=-1.188e0} \
             run={duration_s=6.103e-1,settle_s=1.831e-1}",
            Precision::F64,
        ),
        // Storages behind the bridge that discharge within a step: half the tolerance changed little.
        case(
            "contact-separation",
            "parameters.damping_ratio=1.563 parameters.stick_charge=relaxing \
             parameters.parasitic_capacitance_f=1.996e-13 \
             load={kind='rectified-store',capacitance_f=2.808e-12,initial_v=0.03676,diode_drop_v=0.3,leakage_ohm=7.089e4} \
             excitation={kind='sines',tones=[{amplitude_m_per_s2=4.028,frequency_hz=9.26},{amplitude_m_per_s2=4.028,frequency_hz=17.38}]} \
             run={duration_s=1.5,settle_s=0.45}",
            Precision::F64,
        ),
        case(
            "contact-separation",
            "parameters.damping_ratio=3.487e-2 parameters.force_law=gap-field parameters.stick_charge=relaxing \
             parameters.restitution={kind='velocity-dependent',at_rest=0.3534,at_speed=0.04899,reference_speed_m_per_s=6.092} \
             initial={gap_m=2.409e-6,velocity_m_per_s=-1.687} \
             load={kind='rectified-store',capacitance_f=2.287e-9,initial_v=0.0,diode_drop_v=0.3,leakage_ohm=inf,draw={kind='resistor',value=1.234e5}} \
             excitation={kind='sine',amplitude_m_per_s2=2.395,frequency_hz=11.03,phase_rad=1.614} \
             run={duration_s=0.9992,settle_s=0.2998}",
            Precision::F64,
        ),
        // The storage is full: what the reference delivers, 10⁻¹² of what it holds, is below its own tolerance.
        case(
            "sliding",
            "parameters.beam_length_m=6.785e-2 parameters.beam_width_m=1.789e-2 \
             parameters.beam_thickness_m=5.882e-4 parameters.young_modulus_pa=1.552e11 \
             parameters.density_kg_per_m3=5.814e3 parameters.slider_mass_kg=7.453e-3 \
             parameters.patch_radius_m=1.219e-2 parameters.dielectric_thickness_m=4.235e-5 \
             parameters.relative_permittivity=1.300e0 parameters.charge_density_c_per_m2=1.092e-4 \
             parameters.damping_ratio=8.117e0 parameters.force_law=none \
             parameters.kinetic_friction_active=3.435e-2 parameters.static_friction_active=3.438e-2 \
             parameters.kinetic_friction_inert=1.750e-1 parameters.static_friction_inert=1.752e-1 \
             initial.displacement_m=3.065e-6 initial.velocity_m_per_s=-7.920e-5 \
             load={kind='rectified-store',capacitance_f=1.290e-9,initial_v=3.441e-2,diode_drop_v=0.0,leakage_ohm=inf,draw={kind='power',value=1.021e-9,turn_on_v=4.831,turn_off_v=2.701}} \
             excitation={kind='sine',amplitude_m_per_s2=8.732e-1,frequency_hz=1.095e1,phase_rad=5.619e-1} \
             run={duration_s=1.580,settle_s=0.4741}",
            Precision::F32,
        ),
    ]
}

/// Judged with few attempted steps.
fn effort(by_reference: bool) -> Effort {
    Effort { most_attempts: MOST_ATTEMPTS, by_reference, chaotic_pairs: 16 }
}

/// The findings on cases drawn from a seed, judged by the reference with more steps.
fn drawn(seed: u64, numbers: &[u64]) -> Vec<Finding> {
    let effort = Effort { most_attempts: 5 * MOST_ATTEMPTS, ..effort(true) };
    none_fails(&numbers.iter().map(|&number| (draw(seed, number), effort)).collect::<Vec<_>>())
}

fn none_fails(cases: &[(Case, Effort)]) -> Vec<Finding> {
    let findings = on_all_cores(cases, |(case, effort)| judge(case, *effort));
    let failures: Vec<String> = cases
        .iter()
        .zip(&findings)
        .filter(|(_, finding)| finding.class.is_failure())
        .map(|((case, _), finding)| format!("{:?}: {}: {}", finding.class, finding.reason, case.arguments()))
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    findings
}

/// A case of a shipped scene with these changes.
fn case(scene: &'static str, changes: &str, precision: Precision) -> Case {
    Case::of(scene, &changes.split(' ').collect::<Vec<_>>(), precision)
}

#[test]
fn a_slice_of_the_grids_is_right_or_warns() {
    let kinds = [Kind::ContactSeparation, Kind::Sliding, Kind::BumpStop];
    let all = kinds.into_iter().flat_map(|kind| grid(kind, Extent::Coarse));
    let cases: Vec<(Case, Effort)> = all.step_by(OF_GRID).map(|case| (case, effort(false))).collect();
    let findings = none_fails(&cases);
    let right = findings.iter().filter(|finding| finding.class == Class::Right).count();
    assert!(2 * right > findings.len(), "{right} of {}", findings.len());
}

#[test]
fn random_scenes_are_right_or_warn() {
    let case = |number: u64| (draw(SEED, number), effort(number.is_multiple_of(4)));
    let findings = none_fails(&(0..COUNT).map(case).collect::<Vec<_>>());
    let count = |is: fn(&Finding) -> bool| findings.iter().filter(|finding| is(finding)).count();
    // Most cases were judged, and most of their numbers are useful.
    let counts = [
        count(|finding| finding.error.is_some()),
        count(|finding| finding.class == Class::Right),
        count(|finding| finding.by_reference),
    ];
    let least = [75, 70, 15];
    assert!(counts.iter().zip(least).all(|(count, least)| *count >= least), "{counts:?}");
}

#[test]
fn scenes_that_were_found_wrong_are_right_or_warn() {
    let findings = none_fails(&found().into_iter().map(|case| (case, effort(true))).collect::<Vec<_>>());
    assert!(findings.iter().all(|finding| finding.by_reference || finding.is_chaotic), "{findings:?}");
}

#[test]
fn a_case_follows_from_its_seed_and_number() {
    assert_eq!(draw(SEED, 5), draw(SEED, 5));
    assert_ne!(draw(SEED, 5), draw(SEED, 6));
    assert_ne!(draw(SEED, 5), draw(SEED + 1, 5));
}

/// Cases of seed 13 in which the reference is off: a stiff circuit, noise of 80 kHz, powers that are its rounding.
const REFERENCE_IS_OFF: [u64; 8] = [2534, 3136, 9217, 10_911, 11_576, 13_147, 15_823, 18_954];

/// Cases of seed 13: a release at the crest of the base acceleration, which is within a step; a conduction before the impact
/// that ends a step; powers of 10⁻²¹ and 10⁻⁴³ W.
const FOUND: [u64; 4] = [19_158, 3408, 10_165, 9824];

#[test]
fn events_within_a_step_are_right_and_powers_below_rounding_are_warned() {
    let findings = drawn(13, &FOUND);
    let (events, powers) = findings.split_at(2);
    assert!(events.iter().all(|finding| finding.class == Class::Right), "{findings:?}");
    assert!(powers.iter().all(|finding| finding.is_warned && finding.stated.is_none()), "{findings:?}");
}

/// A case of seed 13 whose next smaller step agreed by chance: a power that is that of the first slide, which one step of any
/// tolerance covers.
const LUCKY: u64 = 9834;

#[test]
fn errors_that_the_next_smaller_step_shares_are_within_the_statement() {
    for finding in drawn(13, &[LUCKY]) {
        let (error, stated) = (finding.error.expect("an error"), finding.stated.expect("a statement"));
        assert!(finding.is_warned && error <= stated, "{finding:?}");
    }
}

/// A case of seed 13 that bounces at a rigid stop without a gap: steps of 1/16 and 1/32 µs agreed by chance, 1 % off.
const BOUNCING: u64 = 8656;

#[test]
fn steps_that_agree_by_chance_at_a_rigid_stop_are_warned() {
    let findings = drawn(13, &[BOUNCING]);
    assert!(findings.iter().all(|finding| finding.is_warned), "{findings:?}");
}

/// A case of seed 407: a chaotic motion behind a bridge that does not conduct.
#[test]
fn a_chaotic_motion_that_delivers_no_power_is_warned() {
    let effort = Effort { most_attempts: 5 * MOST_ATTEMPTS, ..effort(false) };
    let findings = none_fails(&[(draw_varied(407, 151), effort)]);
    for finding in &findings {
        assert_eq!(
            (finding.quantity, finding.is_chaotic, finding.is_warned),
            (Some(Quantity::Motion), true, true)
        );
        // Two standard errors are stated, and one motion of twenty is further off.
        let three_standard_errors = 1.5 * finding.stated.expect("a statement");
        assert!(finding.error.expect("an error") <= three_standard_errors, "{finding:?}");
    }
}

/// Cases of seed 27 with a start charge or voltage, or with a storage that is empty within a step: of six the reference did not connect the draw of a storage that was charged at
/// once, of one the errors are scaled by the first kilovolts, and of one the power of 10⁻⁴⁴ W is the rounding of the reference.
const CHARGED: [u64; 9] = [2690, 3962, 4370, 4798, 5434, 13_982, 14_476, 15_764, 17_494];

#[test]
fn what_a_start_charge_leaves_is_right_or_warned() {
    let findings = drawn(27, &CHARGED);
    assert!(
        findings.iter().all(|finding| matches!(finding.class, Class::Right | Class::Warned)),
        "{findings:?}"
    );
}

#[test]
fn a_reference_that_does_not_repeat_itself_does_not_judge() {
    drawn(13, &REFERENCE_IS_OFF);
}
