
/// The base acceleration of the scene; `None` if it is refused.
pub fn excitation() -> Option<Random<f32, 64>> {
    // Frequency in Hz and one-sided spectral density in (m/s²)²/Hz.
    let density = SpectralDensity::new(&[[10.0, 0.02], [40.0, 0.1], [80.0, 0.05]]).ok()?;
    Random::new(&density, 64, 9).ok()
}
