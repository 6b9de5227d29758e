//! Random scenes of ordinary dimensions with a stated feature: what a draw over all bounds seldom hits.

use std::ops::RangeInclusive;

use super::super::Case;
use super::{BUMP_STOP, CONTACT_SEPARATION, Drawing, Drawn, SLIDING, draw, text};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Feature {
    /// A random acceleration whose band ends 1.05 to 4 times the natural frequency.
    RandomNearResonance,
    /// A weak tone of a hundred to ten thousand times the frequency of a strong one.
    FastTone,
    /// A start charge or voltage behind a bridge.
    StartCharge,
    /// A storage whose start voltage is within a rounding of the turn-on voltage of its draw.
    Threshold,
    Sweep,
    Burst,
    /// A start displaced from rest near the resonance of the passive scene, which has several steady motions.
    Attractors,
    /// Impacts at large amplitudes near the resonance, nine of ten of the beam.
    Chaos,
}

/// Each feature with its share of the cases; the others are drawn over all bounds.
const SHARES: [(Feature, f64); 8] = [
    (Feature::RandomNearResonance, 0.06),
    (Feature::FastTone, 0.06),
    (Feature::StartCharge, 0.06),
    (Feature::Threshold, 0.06),
    (Feature::Sweep, 0.06),
    (Feature::Burst, 0.06),
    (Feature::Attractors, 0.06),
    (Feature::Chaos, 0.2),
];
/// Mixed into the seed, so that the feature is independent of what [`draw`] draws under the same seed.
const OTHER_SEQUENCE: u64 = 0x5851_f42d_4c95_7f2d;
/// Decades up to which a featured scene changes the shipped dimensions and materials.
const SPREAD: f64 = 0.1;

/// A shipped scene as a base of featured ones.
struct Base {
    name: &'static str,
    drawn: Drawn,
    natural_hz: f64,
    /// Amplitudes of the base in m/s² and loads in Ω.
    amplitudes: [f64; 2],
    resistances: [f64; 2],
}

impl Base {
    const fn new(
        (name, drawn): (&'static str, Drawn),
        natural_hz: f64,
        amplitudes: [f64; 2],
        resistances: [f64; 2],
    ) -> Self {
        Self { name, drawn, natural_hz, amplitudes, resistances }
    }
}

const BASES: [Base; 4] = [
    Base::new(("contact-separation", CONTACT_SEPARATION), 20.13, [0.3, 8.0], [1e5, 1e10]),
    Base::new(("sliding", SLIDING), 18.373, [0.5, 5.0], [1e5, 1e10]),
    Base::new(("bump-stop", BUMP_STOP), 240.0, [1.0, 50.0], [1e3, 1e7]),
    Base::new(("contact-separation-passive", CONTACT_SEPARATION), 20.13, [1.0, 4.0], [1e7, 1e9]),
];

/// The case of a number under a seed: with a feature in about three of five, otherwise that of [`draw`].
pub fn draw_varied(seed: u64, number: u64) -> Case {
    let mut source = Source::new(seed ^ OTHER_SEQUENCE, number);
    let mut left = source.uniform(0.0, 1.0);
    for (feature, share) in SHARES {
        if left < share {
            return Drawing { source, changes: Vec::new() }.with(feature);
        }
        left -= share;
    }
    draw(seed, number)
}

impl Drawing {
    fn with(mut self, feature: Feature) -> Case {
        let index = match feature {
            Feature::Chaos if self.source.chance(0.9) => 2,
            Feature::Chaos | Feature::Attractors => 3,
            _ => self.source.one_of([0, 1, 2]),
        };
        let base = &BASES[index];
        // A changed stop or beam may be refused.
        if feature != Feature::Chaos && self.source.chance(0.5) {
            self.multiply(base.drawn, SPREAD);
        }
        self.featured_load(base, feature);
        let factor = self.source.uniform(0.85, 1.15);
        let frequency = base.natural_hz * factor;
        let [low, high] = base.amplitudes;
        let low = if feature == Feature::Chaos { (low * high).sqrt() } else { low };
        let amplitude = self.source.logarithmic(low, high);
        let excitation = self.featured_excitation(feature, frequency, amplitude);
        self.set("excitation", excitation);
        if feature == Feature::Attractors {
            let velocity = self.source.signed(1e-2, 1.0);
            self.set_number("initial.velocity_m_per_s", velocity);
        }
        let duration = 40.0 / base.natural_hz;
        let settle = duration * self.source.one_of([0.0, 0.3]);
        self.set("run", format!("{{duration_s={},settle_s={}}}", text(duration), text(settle)));
        self.case(base.name)
    }

    /// A resistor, or a storage or bus where the feature has one.
    fn featured_load(&mut self, base: &Base, feature: Feature) {
        let [low, high] = base.resistances;
        match feature {
            Feature::StartCharge => {
                let voltage = text(self.source.logarithmic(0.1, 20.0));
                let drop = text(self.source.one_of([0.0, 0.3]));
                let bus = format!("{{kind=\"dc-bus\",voltage_v={voltage},diode_drop_v={drop}}}");
                let store = format!(
                    "{{kind=\"rectified-store\",capacitance_f=1e-7,initial_v={voltage},diode_drop_v={drop}}}"
                );
                let load = self.source.one_of([&bus, &store]).clone();
                self.set("load", load);
                let (key, [least, most]) = match base.name {
                    "bump-stop" => ("initial.voltage_v", [1e-1, 1e3]),
                    _ => ("initial.charge_c", [1e-10, 1e-7]),
                };
                let start = self.source.signed(least, most);
                self.set_number(key, start);
            }
            Feature::Threshold => {
                let on = self.source.uniform(1.0, 5.0);
                let apart = self.source.signed(1e-9, 1e-6);
                let [kind, value] = self.source.one_of([["power", "1e-6"], ["current", "1e-7"]]);
                self.set(
                    "load",
                    format!(
                        "{{kind=\"rectified-store\",capacitance_f=1e-7,initial_v={:e},diode_drop_v=0.3,leakage_ohm=inf,\
                         draw={{kind=\"{kind}\",value={value},turn_on_v={on:e},turn_off_v={}}}}}",
                        on * (1.0 + apart),
                        text(0.6 * on),
                    ),
                );
            }
            _ => {
                let resistance = self.source.logarithmic(low, high);
                self.set_number("load.resistance_ohm", resistance);
            }
        }
    }

    /// The table `excitation`.
    fn featured_excitation(&mut self, feature: Feature, frequency: f64, amplitude: f64) -> String {
        let sine = |amplitude: f64, frequency: f64| {
            format!("amplitude_m_per_s2={},frequency_hz={}", text(amplitude), text(frequency))
        };
        match feature {
            Feature::RandomNearResonance => {
                let top = frequency * self.source.uniform(1.05, 4.0);
                let bottom = frequency * self.source.uniform(0.3, 0.95);
                let density = text(amplitude * amplitude / (top - bottom));
                let lines = self.source.one_of([16, 32, 128, 512]);
                let seed = self.source.whole(0..=u16::MAX);
                format!(
                    "{{kind=\"random\",spectral_density_m2_per_s3=[[{},{density}],[{},{density}]],lines={lines},seed={seed}}}",
                    text(bottom),
                    text(top)
                )
            }
            Feature::FastTone => {
                let fast = (frequency * self.source.logarithmic(100.0, 1e4)).min(9e5);
                let weak = amplitude * self.source.logarithmic(1e-4, 1e-1);
                format!(
                    "{{kind=\"sines\",tones=[{{{}}},{{{}}}]}}",
                    sine(amplitude, frequency),
                    sine(weak, fast)
                )
            }
            Feature::Sweep => {
                let [from, to] = [self.source.uniform(0.3, 0.95), self.source.uniform(1.05, 3.0)];
                let law = self.source.one_of(["linear", "logarithmic"]);
                let sweep_s = self.source.uniform(10.0, 40.0) / frequency;
                format!(
                    "{{kind=\"sweep\",amplitude_m_per_s2={},from_hz={},to_hz={},sweep_s={},law=\"{law}\"}}",
                    text(amplitude),
                    text(from * frequency),
                    text(to * frequency),
                    text(sweep_s)
                )
            }
            Feature::Burst => {
                let cycles = self.source.whole(1..=6);
                let period = text(self.source.uniform(1.1, 4.0) * f64::from(cycles) / frequency);
                format!(
                    "{{kind=\"bursts\",{},cycles={cycles},period_s={period}}}",
                    sine(amplitude, frequency)
                )
            }
            _ => format!("{{kind=\"sine\",{}}}", sine(amplitude, frequency)),
        }
    }
}

/// A sequence of random numbers.
#[derive(Debug, Clone, Copy)]
pub struct Source(u64);

/// The increment of SplitMix64: the golden ratio in 64 bits.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Source {
    /// The sequence of a number under a seed.
    pub(crate) fn new(seed: u64, number: u64) -> Self {
        let mut by_seed = Self(seed);
        Self(by_seed.bits() ^ number.wrapping_mul(GOLDEN))
    }

    /// The sequence of a seed alone.
    pub fn of_seed(seed: u64) -> Self {
        Self(seed)
    }

    /// A whole number of a range.
    pub(crate) fn whole(&mut self, range: RangeInclusive<u16>) -> u16 {
        let count = u64::from(range.end() - range.start()) + 1;
        range.start() + (self.bits() % count) as u16
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// From `lowest` to `highest`, uniform.
    pub fn uniform(&mut self, lowest: f64, highest: f64) -> f64 {
        let part = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        lowest + part * (highest - lowest)
    }

    /// Normal with the variance 1, as the sum of twelve.
    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform(0.0, 1.0) - 0.5).sum()
    }

    /// From `lowest` to `highest`, both above 0, with a uniform logarithm.
    pub(crate) fn logarithmic(&mut self, lowest: f64, highest: f64) -> f64 {
        self.uniform(lowest.ln(), highest.ln()).exp()
    }

    /// Whether an event of this probability happens.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// One of some values, each as probable as another.
    pub(crate) fn one_of<T: Copy, const N: usize>(&mut self, values: [T; N]) -> T {
        values[(self.bits() % N as u64) as usize]
    }

    /// A magnitude as by [`Source::logarithmic`] with a random sign.
    pub(crate) fn signed(&mut self, lowest: f64, highest: f64) -> f64 {
        self.one_of([-1.0, 1.0]) * self.logarithmic(lowest, highest)
    }
}
