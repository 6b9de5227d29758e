//! The work of the electrostatic force over a whole run, against another program: under the transferred-charge law
//! the force gives the mass energy, under the gap-field law it takes what the load receives.
//!
//! The other program is not in this repository: TR-BDF2 with fixed steps and bisected events.

use cross_crate_tests::{contact_separation, value};
use host_bench::embedded::contact_separation_parameters;
use host_bench::scene_file::ForceLaw;
use model_core::clock::Instant;
use model_core::energy::{Ledger, RunMeter};
use model_core::excitation::Sine;
use model_core::integrate::{FixedStep, TrBdf2};
use model_core::observer::{AcceptedStep, Event, Observer, PowerIndex};
use model_core::scalar::Polynomial;
use model_core::scene::contact_separation::Start;
use model_core::scene::{Harvester, Simulation};

/// Counts the events, each of which must be an impact that loses energy.
struct Impacts(u32);

impl Observer<f64> for Impacts {
    fn step(&mut self, _step: &AcceptedStep<'_, f64>) {}

    fn event(&mut self, event: &Event<'_, f64>) {
        // Mode 0 is free motion.
        assert!(event.loss > 0.0 && event.after.mode == 0);
        self.0 += 1;
    }
}

/// Work given up, energy delivered, energy lost in contact over 120 periods at 20 Hz, 50 µC/m², 100 MΩ.
fn works(force_law: ForceLaw) -> [f64; 3] {
    let scene = contact_separation(|_, model| model.parameters.force_law = force_law);
    let model = scene.contact_separation().expect("a contact-separation scene");
    let harvester =
        contact_separation_parameters::<f64, Polynomial>(model, scene.load).build().expect("in bounds");
    let vibration = Sine::<f64>::new(1.962, 20.0, 0.0).expect("in bounds");
    let simulation = Simulation::with_all_powers(
        harvester,
        TrBdf2,
        FixedStep::of_seconds(0.05 / 3200.0).expect("in bounds"),
    );
    let mut state = simulation.start(&Start::default(), &vibration).expect("in bounds");
    let mut ledger = Ledger::open(&simulation.outputs(&state));
    let mut meter = RunMeter::new();
    let mut log = Impacts(0);
    let mut meters = (&mut ledger, &mut meter);
    let mut observer = (&mut meters, &mut log);
    let until = Instant::from_whole_seconds(6);
    simulation.advance(&mut state, &vibration, until, u32::MAX, &mut observer).expect("runs");
    assert_eq!(log.0, meter.report().impacts);
    let charge_moved = meter.integrals().integral(PowerIndex::CurrentMagnitude);
    assert!(charge_moved > 0.0 && value(ledger.residual().largest()) < 1e-6);
    [
        ledger.integrals().integral(PowerIndex::ElectrostaticWork),
        meter.delivered_energy(),
        ledger.lost_in_contact(),
    ]
}

#[test]
fn the_transferred_charge_law_gives_the_mass_energy() {
    let [given_up, delivered, lost] = works(ForceLaw::TransferredCharge);
    println!("given up {given_up:e} J, delivered {delivered:e} J, lost in contact {lost:e} J");
    assert!((given_up + 4.386e-4).abs() < 2e-6, "{given_up:e}");
    assert!((delivered - 5.89e-5).abs() < 3e-7, "{delivered:e}");
    assert!(lost > 0.0);
}

#[test]
fn the_field_of_the_gap_takes_what_the_load_receives() {
    let [given_up, delivered, lost] = works(ForceLaw::GapField);
    println!("given up {given_up:e} J, delivered {delivered:e} J, lost in contact {lost:e} J");
    // What is not delivered is stored in the field.
    assert!((given_up / delivered - 1.0).abs() < 1e-2, "{given_up:e} {delivered:e}");
    assert!(lost > 0.0);
}
