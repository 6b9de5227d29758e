//! Which rows a table of error against run time has.

use serde::{Serialize, Serializer};

use crate::method::{Math, Method, Options, Precision};
use crate::scene_file::{Model, Scene};

/// How a row's step is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// Fixed, a period of the excitation over this number.
    PerPeriod {
        /// Steps per period.
        steps: u32,
        /// The period in s.
        period_s: f64,
    },
    /// Adaptive with this relative tolerance.
    Tolerance(f64),
    /// The method's own.
    Default,
}

impl std::fmt::Display for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::PerPeriod { steps, .. } => write!(f, "T/{steps}"),
            Self::Tolerance(tolerance) => write!(f, "{tolerance:.0e}"),
            Self::Default => write!(f, "default"),
        }
    }
}

impl Serialize for Control {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// One row to run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Variant {
    /// Method.
    pub method: Method,
    /// Precision.
    pub precision: Precision,
    /// Elementary functions of the core; `None` for the reference's integrator, which uses the
    /// host's.
    pub math: Option<Math>,
    /// Step or tolerance.
    pub control: Control,
}

impl Variant {
    /// The reference as it stands.
    #[must_use]
    pub(super) fn reference() -> Self {
        Self { method: Method::Reference, precision: Precision::F64, math: None, control: Control::Default }
    }

    /// The options of its run.
    #[must_use]
    pub fn options(&self) -> Options {
        let (step_s, tolerance) = match self.control {
            Control::PerPeriod { steps, period_s } => (Some(period_s / f64::from(steps)), None),
            Control::Tolerance(tolerance) => (None, Some(tolerance)),
            Control::Default => (None, None),
        };
        let embedded = self.method != Method::Reference;
        Options {
            method: self.method,
            precision: embedded.then_some(self.precision),
            math: self.math,
            step_s,
            long_step_s: None,
            tolerance,
            trace_every_s: None,
            bare: false,
            steady_state: false,
            most_attempts: None,
        }
    }

    /// The name of the method: that of the peer where the reference's integrator runs at another
    /// tolerance than the reference.
    #[must_use]
    pub fn method_name(&self) -> &'static str {
        match (self.method, self.control) {
            (Method::Auto | Method::TrBdf2, Control::PerPeriod { .. }) => "TR-BDF2, fixed step",
            (Method::Auto | Method::TrBdf2, _) => "TR-BDF2, adaptive",
            (Method::Rk4, _) => "explicit RK4, fixed step",
            (Method::DiscreteGradient, _) => "discrete gradient",
            (Method::Newmark, _) => "Newmark",
            (Method::Reference, Control::Default) => "reference",
            (Method::Reference, _) => "diffsol BDF (std)",
        }
    }
}

/// How much is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Most runs of each row.
    pub runs: usize,
    /// Seconds of run time after which a row is not run again.
    pub seconds_per_row: f64,
    /// Whether all methods are run with all math backends and all peers.
    pub whole: bool,
}

impl Extent {
    /// Everything.
    pub const WHOLE: Self = Self { runs: 5, seconds_per_row: 3.0, whole: true };
    /// What fits in half a minute.
    pub const SHORT: Self = Self { runs: 3, seconds_per_row: 0.3, whole: false };
}

/// Steps per period of the implicit method's rows.
const FIXED: [u32; 5] = [200, 400, 800, 1600, 3200];
/// Tolerances of the adaptive rows.
const TOLERANCES: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];
/// Tolerances of the peer.
const PEER: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];

/// The rows of a table for this scene.
#[must_use]
pub fn variants(scene: &Scene, extent: &Extent) -> Vec<Variant> {
    let period_s = period(scene);
    let backends: &[(Precision, Math)] = &[
        (Precision::F64, Math::Polynomial),
        (Precision::F32, Math::Polynomial),
        (Precision::F64, Math::Libm),
        (Precision::F32, Math::Libm),
        (Precision::F32, Math::Micromath),
    ];
    let explicit = explicit_steps(scene, period_s);
    let mut variants = Vec::new();
    for &(precision, math) in backends {
        let mut push = |method, control| {
            variants.push(Variant { method, precision, math: Some(math), control });
        };
        for steps in FIXED {
            push(Method::TrBdf2, Control::PerPeriod { steps, period_s });
        }
        for tolerance in TOLERANCES {
            push(Method::TrBdf2, Control::Tolerance(tolerance));
        }
        if math == Math::Polynomial || extent.whole {
            for &steps in &explicit {
                push(Method::Rk4, Control::PerPeriod { steps, period_s });
            }
        }
    }
    let peers = if extent.whole { &PEER[..] } else { &PEER[..2] };
    variants.extend(peers.iter().map(|&tolerance| Variant {
        method: Method::Reference,
        precision: Precision::F64,
        math: None,
        control: Control::Tolerance(tolerance),
    }));
    variants
}

/// The period of the excitation in s, or of the free motion where it has none.
fn period(scene: &Scene) -> f64 {
    let natural = match &scene.model {
        Model::ContactSeparation(model) => {
            std::f64::consts::TAU * (model.parameters.mass_kg / model.parameters.stiffness_n_per_m).sqrt()
        }
        Model::Sliding(model) => model.parameters.natural_frequency_hz().recip(),
        Model::BumpStop(model) => model.natural_frequencies_hz().first().map_or(1.0, |lowest| lowest.recip()),
    };
    scene.excitation.single_frequency().map_or(natural, f64::recip)
}

/// Steps per period of the explicit method where stability is not what limits them, or none is
/// enough.
const NOT_STIFF: [u32; 5] = [100, 200, 400, 800, 1600];
/// Most steps per period for which the explicit method is tried.
const MOST_EXPLICIT: f64 = 1e5;

/// Steps per period of the explicit method: those of the implicit one, which show where it is
/// unstable, and from there doubled until it is stable at the least capacitance and once more.
fn explicit_steps(scene: &Scene, period_s: f64) -> Vec<u32> {
    const VACUUM_PERMITTIVITY: f64 = 8.854_187_812_8e-12;
    /// Where the method's stability ends on the negative real axis.
    const STABLE: f64 = 2.785;
    let resistance_ohm = scene.load.resistance_ohm();
    let capacitance = match &scene.model {
        Model::ContactSeparation(model) => {
            let from = &model.parameters;
            // The gap of a motion that touches the dielectric.
            let distance =
                2.0 * from.initial_gap_m + from.dielectric_thickness_m / from.relative_permittivity;
            VACUUM_PERMITTIVITY * from.electrode_area_m2 / distance + from.parasitic_capacitance_f
        }
        Model::Sliding(model) => {
            /// Part of the active patch that a wide motion still covers, 1.4 radii off its middle.
            const COVERED: f64 = 0.19;
            let from = &model.parameters;
            let area = std::f64::consts::PI * from.patch_radius_m * from.patch_radius_m;
            let distance = from.dielectric_thickness_m / from.relative_permittivity;
            VACUUM_PERMITTIVITY * area * COVERED / distance
        }
        Model::BumpStop(model) => {
            let from = &model.parameters;
            from.piezo_permittivity_f_per_m * from.beam_width_m * from.beam_length_m / from.piezo_thickness_m
        }
    };
    let stable = period_s / (STABLE * resistance_ohm * capacitance);
    if stable < f64::from(FIXED[2]) || !(stable < MOST_EXPLICIT) {
        return NOT_STIFF.to_vec();
    }
    let fine = (stable / 1000.0).ceil().max(1.0) * 1000.0;
    let fine = if fine < MOST_EXPLICIT { fine as u32 } else { FIXED[4] };
    vec![FIXED[2], FIXED[4], fine / 2, fine, fine * 2]
}
