//! The contacts of a run, one by one.

use model_core::observer::{AcceptedStep, Event, Observer};

use super::observed::observed;
use harvester_scene::method::{Failure, Options};
use harvester_scene::scene_file::Scene;

/// An interval of the run in which beam and stop touch, in s; of no length for a rigid impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactInterval {
    /// Time in s at which the contact begins.
    pub begins_s: f64,
    /// Time in s at which it ends.
    pub ends_s: f64,
}

impl ContactInterval {
    /// Its length in s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.ends_s - self.begins_s
    }
}

/// Longest pause within a chattering phase, in periods of the base.
const PAUSE: f64 = 0.125;

/// The chattering phases of some contacts in order of time: contacts less than an eighth of the period in s apart.
pub fn chattering_phases(
    contacts: &[ContactInterval],
    period_s: f64,
) -> impl Iterator<Item = &[ContactInterval]> {
    contacts.chunk_by(move |one, next| next.begins_s - one.ends_s < PAUSE * period_s)
}

/// The contacts of a bump-stop scene that begin in its measuring window, in order of time, on the embedded core in
/// double precision.
pub fn contact_intervals(scene: &Scene, options: &Options) -> Result<Vec<ContactInterval>, Failure> {
    let mut contacts = Contacts { from_s: scene.run.settle_s, closed: false, found: Vec::new() };
    observed(scene, options, scene.run.duration_s, &mut contacts, |_| false)?;
    Ok(contacts.found)
}

/// Collects the contacts that begin after an instant.
struct Contacts {
    from_s: f64,
    /// Whether the last step ended in contact.
    closed: bool,
    found: Vec<ContactInterval>,
}

impl Contacts {
    /// A contact from one instant to another, both in s; `continues` the last one.
    fn add(&mut self, begins_s: f64, ends_s: f64, continues: bool) {
        match self.found.last_mut() {
            Some(last) if continues => last.ends_s = ends_s,
            _ if begins_s >= self.from_s && !continues => {
                self.found.push(ContactInterval { begins_s, ends_s })
            }
            _ => {}
        }
    }
}

impl Observer<f64> for Contacts {
    fn step(&mut self, step: &AcceptedStep<'_, f64>) {
        let touches = step.contact.force > 0.0;
        if touches {
            let from_s = step.from.seconds::<f64>();
            let at = |fraction: f64| from_s + fraction * step.step;
            self.add(at(step.contact.begins), at(step.contact.ends), self.closed);
        }
        self.closed = touches && step.end.in_contact;
    }

    fn event(&mut self, event: &Event<'_, f64>) {
        if event.impact_speed.is_some() {
            let at = event.at.seconds::<f64>();
            self.add(at, at, false);
            // A contact that begins with the impact is the same contact.
            self.closed = true;
        }
    }
}
