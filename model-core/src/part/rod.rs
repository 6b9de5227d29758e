//! Computes the axial modes of a uniform rod, fixed at one end and free at the other.
//!
//! `−EA z'' + m' z̈ = f` on `0 ≤ ξ ≤ L`: `Ω_j = (2j − 1) π c / 2L` with `c = √(EA/m')`, and mass-normalised
//! shapes `ψ_j(ξ) = √(2/m_r) sin((2j − 1) π ξ / 2L)`, with `m_r = m' L`.

use crate::scalar::Scalar;

/// A uniform rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rod<S> {
    /// Length `L` in m.
    pub length: S,
    /// Axial stiffness `EA` in N.
    pub axial_stiffness: S,
    /// Mass per length `m' = ρA` in kg/m.
    pub mass_per_length: S,
}

/// One mode of a [`Rod`], normalised to a modal mass of one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RodMode<S> {
    /// Undamped angular frequency `Ω` in rad/s.
    pub angular_frequency: S,
    /// `ψ(L)` in 1/√kg; its sign alternates from mode to mode.
    pub tip: S,
    /// `∫ m' ψ dξ` in √kg: the modal force per negative base acceleration.
    pub base_coupling: S,
}

/// Number of modes after the kept ones that the residual compliance sums one by one.
const SUMMED: u32 = 30;

impl<S: Scalar> Rod<S> {
    /// Mode `number`, from 1, in order of frequency.
    pub(crate) fn mode(&self, number: u32) -> RodMode<S> {
        let (two, number) = (S::from_f64(2.0), number.max(1));
        let odd = S::from_u32((number << 1).wrapping_sub(1));
        let quarter_turns = S::from_f64(core::f64::consts::FRAC_PI_2) * odd;
        let mass = self.mass_per_length * self.length;
        let rate = (self.axial_stiffness / self.mass_per_length).sqrt() / self.length;
        let amplitude = (two / mass).sqrt();
        RodMode {
            angular_frequency: quarter_turns * rate,
            tip: if number % 2 == 1 { amplitude } else { -amplitude },
            base_coupling: (two * mass).sqrt() / quarter_turns,
        }
    }

    /// Static compliance at the tip, in m/N, of all modes after the first `kept`: `Σ ψ_j²/Ω_j² = (8/π²)
    /// (L/EA) Σ 1/(2j − 1)²`. For `kept` = 0 it is that of the massless rod, `L/EA`.
    ///
    /// The omitted modes are summed directly, because the difference of the total and the kept modes cancels.
    pub(crate) fn residual_compliance(&self, modes: u32) -> S {
        let compliance = self.length / self.axial_stiffness;
        if modes == 0 {
            return compliance;
        }
        let mut sum = S::ZERO;
        let last = modes.saturating_add(SUMMED);
        for number in (modes.wrapping_add(1)..=last).rev() {
            let odd = S::from_u32((number << 1).wrapping_sub(1));
            sum += S::ONE / (odd * odd);
        }
        // Remaining modes by the Euler–Maclaurin formula at the midpoints: 1/4n − 1/48n³ + 7/960n⁵.
        let n = S::from_u32(last);
        let square = n * n;
        let correction = S::from_f64(1.0 / 48.0) - S::from_f64(7.0 / 960.0) / square;
        let rest = (S::from_f64(0.25) - correction / square) / n;
        S::from_f64(8.0 / (core::f64::consts::PI * core::f64::consts::PI)) * compliance * (sum + rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The aluminium stop: 20 mm long, 2 × 2 mm.
    const STOP: Rod<f64> = Rod { length: 0.02, axial_stiffness: 70e9 * 4e-6, mass_per_length: 2700.0 * 4e-6 };

    #[test]
    fn the_rod_of_the_bump_stop_has_its_known_modes() {
        let first = STOP.mode(1);
        assert!((first.angular_frequency / core::f64::consts::TAU - 63_646.885).abs() < 1e-3);
        assert!((first.tip - 96.225_044_9).abs() < 1e-7);
        assert!((first.base_coupling - 0.013_231_89).abs() < 1e-8);
        let third = STOP.mode(3);
        assert!((third.angular_frequency / first.angular_frequency - 5.0).abs() < 1e-14);
        assert_eq!((third.tip, STOP.mode(2).tip), (first.tip, -first.tip));
        // All the mass takes part: Σ g² → m_r, of which n modes miss about 2/(π² n).
        let coupled: f64 = (1..=1000).map(|j| STOP.mode(j).base_coupling.powi(2)).sum();
        assert!((coupled / 2.16e-4 - 1.0).abs() < 3e-4);
    }

    #[test]
    fn retained_and_residual_modes_make_the_whole_compliance() {
        let whole = STOP.length / STOP.axial_stiffness;
        for modes in [0_u32, 1, 2, 5, 10, 20] {
            let modal_part: f64 =
                (1..=modes).map(|j| (STOP.mode(j).tip / STOP.mode(j).angular_frequency).powi(2)).sum();
            let sum = modal_part + STOP.residual_compliance(modes);
            assert!((sum / whole - 1.0).abs() < 1e-12, "{modes} {}", sum / whole - 1.0);
            let single = Rod {
                length: STOP.length as f32,
                axial_stiffness: STOP.axial_stiffness as f32,
                mass_per_length: STOP.mass_per_length as f32,
            };
            let relative =
                f64::from(single.residual_compliance(modes)) / STOP.residual_compliance(modes) - 1.0;
            assert!(relative.abs() < 1e-6, "{modes} {relative}");
        }
    }
}
