//! The energy that a force law creates, and the warning of it.

use serde::Serialize;

use crate::scene_file::{ForceLaw, Model, Scene};

/// Share of the delivered energy above which a run warns of created energy.
const NOTABLE: f64 = 1e-2;

/// The energy that the force law of a triboelectric scene created in the measuring window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CreatedEnergy {
    /// What the field gained from the motion less what the motion lost to the force, in J. Negative: energy vanished.
    pub created_energy_j: f64,
    /// It over the energy that was delivered to the load in the same window. `None` where none was delivered, and where the
    /// error of the integration hides it.
    pub created_energy_share: Option<f64>,
}

impl CreatedEnergy {
    /// Of the created and the delivered energy in J, and the larger of the remainders in J of the mechanical and the
    /// electrical ledger, to which the created energy is known.
    ///
    /// With a load near 0 Ω or an open one the force is a function of the position: a cycle of the motion creates nothing,
    /// the load takes next to nothing, and their quotient would be that of two errors.
    pub fn new(created_energy_j: f64, delivered_energy_j: f64, remainder_j: f64) -> Self {
        let is_known = created_energy_j == 0.0
            || remainder_j.abs() <= created_energy_j.abs().max(NOTABLE * delivered_energy_j);
        let share = (delivered_energy_j > 0.0 && is_known).then(|| created_energy_j / delivered_energy_j);
        Self { created_energy_j, created_energy_share: share.filter(|share| share.is_finite()) }
    }
}

/// The warning of a scene whose force law is not derived from the field, where the energy that it created is more than
/// a hundredth of the delivered energy.
pub fn created_energy_warning(scene: &Scene, created: CreatedEnergy) -> Option<String> {
    let [law, passive] = laws(scene)?;
    let share = created.created_energy_share.filter(|share| share.abs() > NOTABLE)?;
    let does = if share > 0.0 { "creates" } else { "loses" };
    Some(format!(
        "{law} {does} energy: created_energy_j = {:.3e} is {share:.3} times the delivered energy; {passive} conserves it",
        created.created_energy_j,
    ))
}

/// The key of the scene whose value does not conserve the energy of motion and field, and the value that does; `None`
/// where it is conserved.
fn laws(scene: &Scene) -> Option<[&'static str; 2]> {
    match &scene.model {
        Model::ContactSeparation(model) => {
            let law = match model.parameters.force_law {
                ForceLaw::GapField => return None,
                ForceLaw::TransferredCharge => "force_law = \"transferred-charge\"",
                ForceLaw::None => "force_law = \"none\"",
            };
            Some([law, "\"gap-field\""])
        }
        // The normal force has no work: it acts on the friction, which only takes energy.
        Model::Sliding(model) => {
            (!model.parameters.lateral_force).then_some(["lateral_force = false", "true"])
        }
        Model::BumpStop(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(created: f64, delivered: f64, remainder: f64) -> Option<f64> {
        CreatedEnergy::new(created, delivered, remainder).created_energy_share
    }

    #[test]
    fn the_share_is_of_the_delivered_energy_and_absent_without_it() {
        assert_eq!(share(3.0, 2.0, 0.0), Some(1.5));
        assert_eq!(share(-1.0, 2.0, 0.0), Some(-0.5));
        for delivered in [0.0, -0.0, -1.0, f64::NAN] {
            assert_eq!(share(1.0, delivered, 0.0), None, "{delivered}");
        }
        assert_eq!(share(0.0, 0.0, 0.0), None);
        assert_eq!(share(1e300, 1e-300, 0.0), None);
        assert_eq!(share(f64::NAN, 1.0, 0.0), None);
    }

    #[test]
    fn the_share_is_absent_where_the_remainder_of_the_ledger_hides_it() {
        // As large as what was created, and more than a hundredth of what was delivered.
        assert_eq!(share(1.0, 1e-3, 2.0), None);
        assert_eq!(share(1.0, 1e-3, 0.5), Some(1e3));
        assert_eq!(share(1.0, 1e-3, f64::NAN), None);
        // A small share is known to a hundredth.
        assert_eq!(share(1e-4, 1.0, 5e-3), Some(1e-4));
        // Nothing is created where force and field are one expression.
        assert_eq!(share(0.0, 1e-3, 2.0), Some(0.0));
    }
}
