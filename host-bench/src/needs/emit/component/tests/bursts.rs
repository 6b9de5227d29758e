
/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<Burst<f32>> {
    Burst::cycles(2.5, 50.0, 3).ok()?.starting_at(0.05).ok()?.every(0.25).ok()
}
