
/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<Burst<f32>> {
    Burst::half_sine(-30.0, 0.011).ok()?.starting_at(0.1).ok()
}
