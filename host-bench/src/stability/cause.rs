//! The physics that ended a run, from its error.

/// The beginning of a named error, and the cause in words.
const CAUSES: [(&str, &str); 4] = [
    ("displacement = ", "left the overlap of the patches"),
    ("gap coordinate = ", "the motion of the beam grew beyond every number"),
    ("the step shrank to nothing", "step underflow"),
    ("events follow one another without end", "events without end"),
];

/// The cause of a named error of a run, in words.
#[must_use]
pub fn cause(reason: &str) -> String {
    let known = CAUSES.iter().find(|(beginning, _)| reason.starts_with(beginning));
    // Of an error without a cause here, the words before its first number.
    let words = || reason.split(" at ").next().unwrap_or(reason).to_owned();
    known.map_or_else(words, |(_, cause)| (*cause).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Precision;
    use crate::stability::{Case, Class, Effort, judge};

    #[test]
    fn a_slider_that_is_shaken_too_much_leaves_the_overlap() {
        let changes = [
            "parameters.kinetic_friction_active=0",
            "parameters.kinetic_friction_inert=0",
            "excitation.amplitude_m_per_s2=30",
            "run={duration_s=0.5,settle_s=0}",
        ];
        let effort = Effort { most_attempts: 100_000, by_reference: false };
        let found = judge(&Case::of("sliding", &changes, Precision::F64), effort);
        assert_eq!(found.class, Class::NamedError, "{found:?}");
        assert_eq!(cause(&found.reason), "left the overlap of the patches");
    }

    #[test]
    fn an_unknown_error_is_its_own_cause() {
        assert_eq!(cause("the store is flat at 0.5 s: gap_m 1e-3"), "the store is flat");
    }
}
