//! The workloads of the bench. The host runs them too and compares the bits.

pub mod building;
pub mod bump_stop;
pub mod contact_separation;
pub mod emitted;
pub mod estimators;
pub mod peer;
pub mod response_map;
pub mod run;
pub mod sliding;

/// A workload of the bench.
///
/// The bench uses it as `dyn Workload`, so that the code around it is the same machine code in `empty` and in
/// `bench`. The difference of the two sizes is the workload's.
pub trait Workload {
    /// One word, for the log.
    fn name(&self) -> &'static str;

    /// Runs up to the next sample. The bench measures this call only.
    fn advance(&mut self) -> Progress;

    /// The state as raw bits, for an exact comparison with the host.
    fn state(&self) -> &[u32];
}

/// Takes the workloads of a variant, one after the other. A variant gives `None` if a workload is refused.
pub type Visit<'a> = &'a mut dyn FnMut(&mut dyn Workload);

/// Gives a workload to `visit`; `None` if the workload was refused.
#[inline(always)]
pub(crate) fn show<W: Workload>(visit: Visit<'_>, mut workload: Option<W>) -> Option<()> {
    // By reference: a move would put a second copy of the workload on the stack.
    visit(workload.as_mut()?);
    Some(())
}

/// The result of [`Workload::advance`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The next sample.
    Sample {
        /// Steps since the last sample.
        steps: u32,
        /// Simulated microseconds since the last sample.
        simulated_us: u32,
    },
    /// There are no more samples.
    Finished,
    /// The model could not be stepped.
    Failed,
}
