//! The shipped contact-separation scene on the embedded core, for the benches.

use harvester_engine::embedded::contact_separation_parameters;
use harvester_scene::scene_file::{self, Override};
use model_core::clock::Instant;
use model_core::energy::PowerMeter;
use model_core::excitation::Sine;
use model_core::hybrid::{Driver, HybridState};
use model_core::integrate::{Adaptive, ExponentialRadau};
use model_core::part::load::Resistor;
use model_core::part::parasitic::ParasiticCapacitance;
use model_core::part::restitution::{AnyRestitution, VelocityDependentRestitution};
use model_core::scalar::{Mathematics, Scalar};
use model_core::scene::contact_separation::{
    AnyChoices, Choices, ContactSeparation, Mode, Parameters, Parts, STATES, Start, TransferredCharge,
};

/// A state that carries the delivered energy only, as firmware does.
pub type State<S> = HybridState<S, Mode, STATES, 1>;

/// The parts of the shipped scene, chosen at compile time.
pub type Shipped<S, M> =
    Choices<Resistor<S>, VelocityDependentRestitution<S, M>, TransferredCharge, ParasiticCapacitance<S>>;

fn parameters<S: Scalar, M: Mathematics<S>>(resistance_ohm: f64) -> Parameters<S, AnyChoices<S, M>> {
    let load = Override::new("load.resistance_ohm", &resistance_ohm.to_string());
    let scene = scene_file::read(&scene_file::shipped("contact-separation"), &[load])
        .expect("the shipped scene is valid");
    let model = scene.contact_separation().expect("the shipped scene");
    contact_separation_parameters::<S, M>(model, scene.load)
}

/// The shipped scene, every choice at run time.
pub fn any<S: Scalar, M: Mathematics<S>>(resistance_ohm: f64) -> ContactSeparation<S, AnyChoices<S, M>> {
    parameters(resistance_ohm).build().expect("the shipped scene is valid")
}

/// The same with the choices made at compile time.
pub fn shipped<S: Scalar, M: Mathematics<S>>(resistance_ohm: f64) -> ContactSeparation<S, Shipped<S, M>> {
    let any = parameters::<S, M>(resistance_ohm);
    let AnyRestitution::VelocityDependent(restitution) = any.choices.restitution else {
        panic!("the shipped scene's restitution depends on the speed");
    };
    let choices = Choices::new(Resistor { resistance: any.choices.load.resistance }, restitution)
        .force_law(TransferredCharge)
        .parasitic(any.choices.parasitic);
    any.with_choices(choices).build().expect("the shipped scene is valid")
}

/// Its excitation.
pub fn excitation<S: Scalar, M: Mathematics<S>>() -> Sine<S, M> {
    Sine::new(S::from_f64(0.2 * model_core::part::GRAVITY), S::from_f64(20.0), S::ZERO).expect("a sine")
}

/// An adaptive run of the scene with a meter of the delivered energy.
#[derive(Debug)]
pub struct Runner<S: Scalar, M, P: Parts<S>> {
    pub scene: ContactSeparation<S, P>,
    pub excitation: Sine<S, M>,
    driver: Driver<ExponentialRadau, Adaptive<S>>,
}

impl<S: Scalar, M: Mathematics<S>, P: Parts<S>> Runner<S, M, P> {
    pub fn new(scene: ContactSeparation<S, P>, tolerance: f64) -> Self {
        let driver = Driver::new(ExponentialRadau, Adaptive::new(S::from_f64(tolerance)).expect("in bounds"));
        Self { scene, excitation: excitation(), driver }
    }

    /// At rest.
    pub fn start(&self) -> State<S> {
        self.scene.start(&Start::default(), &self.excitation, &self.driver.control).expect("a valid start")
    }

    /// Runs to a time in s; gives the energy delivered to the load in J and the number of steps.
    pub fn run_to(&self, state: &mut State<S>, seconds: f64) -> (S, u32) {
        let until = Instant::from_seconds(seconds).expect("a time");
        let mut meter = PowerMeter::new();
        let advance = self
            .driver
            .advance(&self.scene, state, &self.excitation, until, u32::MAX, &mut meter)
            .expect("the scene runs");
        (meter.delivered_energy(), advance.work.steps)
    }
}
