use std::path::PathBuf;

use super::*;
use crate::scene_file::{self, Override};

/// The excitation of the shipped scene with another table.
fn read(table: &str) -> Result<Excitation, String> {
    let overrides = [Override::new("excitation", table)];
    let file: PathBuf = scene_file::shipped("contact-separation");
    scene_file::read(&file, &overrides).map(|scene| scene.excitation).map_err(|error| error.to_string())
}

const RANDOM: &str =
    "kind = \"random\", seed = 7, spectral_density_g2_per_hz = [[10, 0.015], [40, 0.015], [500, 0.00015]]";

#[test]
fn each_kind_is_read_with_its_defaults() {
    let shock = read("{kind = \"half-sine\", amplitude_g = 50, duration_s = 11e-3}").expect("valid");
    let expected = Burst {
        amplitude_m_per_s2: 50.0 * GRAVITY,
        shape: BurstShape::HalfSine { duration_s: 11e-3 },
        start_s: 0.0,
        period_s: None,
    };
    assert_eq!(shock, Excitation::Burst(expected));
    let bursts = "{kind = \"bursts\", amplitude_m_per_s2 = 3, frequency_hz = 20, cycles = 5, start_s = 1, period_s = 2}";
    let expected = Burst {
        amplitude_m_per_s2: 3.0,
        shape: BurstShape::Cycles { frequency_hz: 20.0, cycles: 5 },
        start_s: 1.0,
        period_s: Some(2.0),
    };
    assert_eq!(read(bursts), Ok(Excitation::Burst(expected)));
    let sweep = "{kind = \"sweep\", amplitude_m_per_s2 = 3, from_hz = 10, to_hz = 55, sweep_s = 60, law = \"logarithmic\"}";
    let expected = Sweep {
        amplitude_m_per_s2: 3.0,
        from_hz: 10.0,
        to_hz: 55.0,
        sweep_s: 60.0,
        logarithmic: true,
        phase_rad: 0.0,
    };
    assert_eq!(read(sweep), Ok(Excitation::Sweep(expected)));
    let Ok(Excitation::Random(random)) = read(&format!("{{{RANDOM}}}")) else { panic!("refused") };
    assert_eq!((random.lines, random.seed, random.tones.len()), (1024, 7, 1024));
    assert!((random.rms_m_per_s2() / GRAVITY - 1.04).abs() < 0.005);
    let metric = RANDOM.replace("g2_per_hz", "m2_per_s3");
    let Ok(Excitation::Random(random)) = read(&format!("{{{metric}, lines = 64}}")) else {
        panic!("refused")
    };
    assert!((random.rms_m_per_s2() - 1.04).abs() < 0.005 && random.tones.len() == 64);
}

#[test]
fn what_is_out_of_bounds_is_named_with_its_bound() {
    let shock = "kind = \"half-sine\", amplitude_g = 50, duration_s = 11e-3";
    let bursts = "kind = \"bursts\", amplitude_m_per_s2 = 3, frequency_hz = 20";
    let sweep = "kind = \"sweep\", amplitude_m_per_s2 = 3, sweep_s = 60, law = \"linear\", from_hz = 10";
    let cases = [
        (
            "kind = \"half-sine\", amplitude_g = 50".to_owned(),
            "duration_s: is missing; must be a number from 1e-6 to 1e6",
        ),
        (format!("{shock}, period_s = 5e-3"), "must not be shorter than the 0.011 s of one"),
        (format!("{shock}, start_s = -1"), "start_s = -1: must be a number from 0 to 1e6"),
        (format!("{shock}, perod_s = 1"), "perod_s"),
        (format!("{bursts}, cycles = 1.5"), "cycles = 1.5: must be a whole number from 1 to 1000000"),
        (format!("{bursts}, cycles = 0"), "cycles = 0: must be a whole number"),
        (bursts.replace("20", "0"), "frequency_hz = 0: must be a number from 1e-6 to 1e6"),
        (
            format!("{sweep}, to_hz = 10"),
            "to_hz = 10: must differ from from_hz by a factor of at least 1.001",
        ),
        (format!("{sweep}, to_hz = 1e7"), "to_hz = 1e7: must be a number from"),
        (format!("{sweep}, to_hz = 50, low = 3"), "low"),
        (RANDOM.replace("seed = 7", "seed = -1"), "seed = -1: must be a whole number from 0 to 4294967295"),
        (RANDOM.replace("seed = 7, ", ""), "seed: is missing; must be a whole number from 0 to 4294967295"),
        (format!("{RANDOM}, lines = 8"), "lines = 8: must be a whole number from 16 to 4096"),
        (format!("{RANDOM}, spectral_density_m2_per_s3 = [[1, 1], [2, 1]]"), "must not be given beside"),
        (RANDOM.replace("_per_hz", "_per_Hz"), "probably spectral_density_g2_per_hz misspelt"),
        (
            RANDOM.replace("[40,", "[10,"),
            "the frequency of point 1 is 10 Hz, must be above the 10 Hz before it",
        ),
        (
            RANDOM.replace("[10,", "[0,"),
            "the frequency of point 0 is 0, must be a number from 1e-3 to 1e5 Hz",
        ),
        (RANDOM.replace("0.00015", "0"), "the density of point 2 is 0, must be a number from 1e-13 to 1e6"),
        (RANDOM.replace("0.00015", "-1"), "the density of point 2 is -1, must be"),
        (RANDOM.replace("[40, 0.015]", "[40]"), "item 1 is"),
        (
            "kind = \"random\", seed = 7, spectral_density_g2_per_hz = [[10, 1]]".to_owned(),
            "must be a list of 2 to 1000 points, each a list of two numbers",
        ),
    ];
    for (table, expected) in cases {
        let error = read(&format!("{{{table}}}")).expect_err(&table);
        assert!(error.contains(expected), "{table}: {error}");
    }
}
