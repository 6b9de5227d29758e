
/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<Sweep<f32>> {
    Sweep::new(4.0, [10.0, 40.0], 2.0, SweepLaw::Linear, 0.5).ok()
}
