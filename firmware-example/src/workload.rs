//! What the firmware measures, and the host runs beside it to compare the bits.

pub mod bump_stop;
pub mod contact_separation;
pub mod estimators;
pub mod hybrid_run;
#[cfg(all(target_os = "none", feature = "peer"))]
pub mod peer;
pub mod sliding;

/// Something to measure.
///
/// It is used as `dyn Workload`, so that the code around it is the same machine code in `empty`
/// and in `bench`, and the difference of their sizes is the workload's own.
pub trait Workload {
    /// One word, for the log.
    fn name(&self) -> &'static str;

    /// Runs up to the next sample. This, and nothing else, is measured.
    fn advance(&mut self) -> Progress;

    /// The state as raw bits, for a comparison with the host that forgives nothing.
    fn state(&self) -> &[u32];
}

/// What a call of [`Workload::advance`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// It got to the next sample.
    Sample {
        /// Steps taken since the last one.
        steps: u32,
        /// Simulated microseconds since the last one.
        simulated_us: u32,
    },
    /// There was nothing left to do.
    Finished,
    /// It could not go on.
    Failed,
}
