//! The excitation of a scene as Rust source, with a test of the mean power under it.

use super::component::number;
use crate::scene_file::{Burst, BurstShape, Excitation, Random, Sweep, Tone};

#[cfg(test)]
mod tests;

/// The function `excitation` and a test of the mean power; nothing for a trace, which stays in its file.
pub(super) fn source(excitation: &Excitation) -> String {
    function(excitation).map_or_else(String::new, |function| format!("{function}{TEST}"))
}

fn function(excitation: &Excitation) -> Option<String> {
    let (of_type, body) = match excitation {
        Excitation::Sine(tone) => ("Sine<f32>".to_owned(), format!("    Sine::new({}).ok()\n", sine(tone))),
        Excitation::Sines(tones) => (format!("Tones<f32, {}>", tones.len()), sum(tones)),
        Excitation::Burst(given) => ("Burst<f32>".to_owned(), burst(given)),
        Excitation::Sweep(given) => ("Sweep<f32>".to_owned(), sweep(given)),
        Excitation::Random(given) => (format!("Random<f32, {}>", given.lines), random(given)),
        Excitation::Silence => ("Silence".to_owned(), "    Some(Silence)\n".to_owned()),
        Excitation::File(_) => return None,
    };
    Some(format!(
        "
/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<{of_type}> {{
{body}}}
"
    ))
}

/// The arguments of `Sine::new`.
fn sine(tone: &Tone) -> String {
    [tone.amplitude_m_per_s2, tone.frequency_hz, tone.phase_rad].map(number).join(", ")
}

fn sum(tones: &[Tone]) -> String {
    let push = |tone| format!("    tones.push(Sine::new({}).ok()?).ok()?;\n", sine(tone));
    let pushed: String = tones.iter().map(push).collect();
    format!("    let mut tones = Tones::new();\n{pushed}    Some(tones)\n")
}

fn burst(given: &Burst) -> String {
    let amplitude = number(given.amplitude_m_per_s2);
    let once = match given.shape {
        BurstShape::HalfSine { duration_s } => format!("half_sine({amplitude}, {})", number(duration_s)),
        BurstShape::Cycles { frequency_hz, cycles } => {
            format!("cycles({amplitude}, {}, {cycles})", number(frequency_hz))
        }
    };
    let start = number(given.start_s);
    let again = given.period_s.map_or_else(String::new, |period| format!("?.every({})", number(period)));
    // One `?` for each fallible call: the function returns an option.
    let chain = format!("Burst::{once}?.starting_at({start}){again}").replace('?', ".ok()?");
    format!("    {chain}.ok()\n")
}

fn sweep(given: &Sweep) -> String {
    let law = if given.logarithmic { "Logarithmic" } else { "Linear" };
    let [amplitude, from, to, seconds, phase] =
        [given.amplitude_m_per_s2, given.from_hz, given.to_hz, given.sweep_s, given.phase_rad].map(number);
    format!("    Sweep::new({amplitude}, [{from}, {to}], {seconds}, SweepLaw::{law}, {phase}).ok()\n")
}

fn random(given: &Random) -> String {
    let points: Vec<String> =
        given.density.iter().map(|point| format!("[{}]", point.map(number).join(", "))).collect();
    format!(
        "    // Frequency in Hz and one-sided spectral density in (m/s²)²/Hz.
    let density = SpectralDensity::new(&[{}]).ok()?;
    Random::new(&density, {}, {}).ok()
",
        points.join(", "),
        given.lines,
        given.seed
    )
}

const TEST: &str = "
#[cfg(test)]
mod tests {
    use model_core::clock::{Instant, TICKS_PER_SECOND};
    use model_core::energy::PowerMeter;
    use model_core::scene::Harvester;

    use super::{ACCURACY, MEAN_POWER, WINDOW_TICKS, excitation, harvester, start};

    #[test]
    fn the_mean_power_is_that_of_the_full_scene() {
        let (Some(harvester), Some(excitation)) = (harvester(), excitation()) else { panic!(\"refused\") };
        let mut state = harvester.start(&start(), &excitation).expect(\"starts\");
        let mut meter = PowerMeter::new();
        for ticks in WINDOW_TICKS {
            meter = PowerMeter::new();
            let until = Instant::from_ticks(ticks);
            let advance = harvester.advance(&mut state, &excitation, until, u32::MAX, &mut meter);
            assert!(advance.is_ok());
        }
        let [settled, end] = WINDOW_TICKS;
        let seconds = (end - settled) as f32 / TICKS_PER_SECOND as f32;
        let change = meter.delivered_energy() / seconds / MEAN_POWER - 1.0;
        assert!(change.abs() <= ACCURACY, \"{change}\");
    }
}
";
