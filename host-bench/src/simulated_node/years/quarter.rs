//! A quarter of a year of a node, and what happens to it.

use model_core::node::IncomeOfTime;

use crate::method::Failure;

/// What happens to a node beside nights, weekends and seasons.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stress {
    #[default]
    None,
    /// The harvester gives a fifth less at the end.
    Ageing,
    /// The clock is set forward or back by up to an hour, each five to seven days.
    Clock,
    /// Each thirty days another firmware, with intervals, energies and reserve that differ by a hundredth.
    Updates,
    /// Resets and losses of power between images, each few days.
    PowerLoss,
    /// The leakage goes by 60 % to either side over the year, which its tolerance allows, the income by a tenth.
    Temperature,
}

impl Stress {
    pub(super) const ALL: [Self; 6] =
        [Self::None, Self::Ageing, Self::Clock, Self::Updates, Self::PowerLoss, Self::Temperature];
}

/// A quarter of a year of a node. Energies in J since the start.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Quarter {
    pub tier: &'static str,
    pub storage: &'static str,
    pub capacitance_f: f64,
    pub still_nights: bool,
    pub stress: Stress,
    pub quarter: u32,
    pub hours: u32,
    /// Share of the hours whose estimate lies within its bound.
    pub inside: f64,
    /// Median of the bounds of its hours over that of the first quarter.
    pub bound_over_first: f64,
    /// The same of the hours without a reading of a full or unknown storage; NaN without such hours in either quarter.
    pub resolved_over_first: f64,
    /// Share of the hours with such a reading.
    pub silent: f64,
    pub sum_estimated_j: f64,
    pub sum_bound_j: f64,
    pub sum_true_j: f64,
    /// Spent on estimation over the income of the quarter.
    pub share: f64,
    /// Images of its own that were not taken or not read.
    pub refused_images: u32,
    /// Hours in which a node that was on did not read its storage.
    pub frozen_hours: u32,
    /// Hours without an estimate.
    pub not_a_number: u32,
}

/// The hours of a quarter: how many are inside, and the bounds of all and of those without silence; both medians of the first quarter. In J.
#[derive(Debug, Default)]
pub(super) struct Hours {
    inside: u32,
    bounds: [Vec<f32>; 2],
    first: Option<[f32; 2]>,
}

impl Hours {
    /// The quarter with what its hours came to; those of the next one are to come.
    pub(super) fn close(&mut self, quarter: Quarter) -> Quarter {
        let medians = self.bounds.each_mut().map(|bounds| {
            bounds.sort_by(f32::total_cmp);
            bounds.get(bounds.len() / 2).copied().unwrap_or(f32::NAN)
        });
        let first = *self.first.get_or_insert(medians);
        let [bound_over_first, resolved_over_first] =
            [0, 1].map(|index| f64::from(medians[index] / first[index]));
        let [inside, resolved] =
            [self.inside as usize, self.bounds[1].len()].map(|count| count as f64 / f64::from(quarter.hours));
        *self = Self { first: self.first, ..Self::default() };
        Quarter { inside, bound_over_first, resolved_over_first, silent: 1.0 - resolved, ..quarter }
    }
}

impl Quarter {
    /// Counts an hour with its true income in J.
    pub(super) fn count(&mut self, hour: IncomeOfTime, truth: f64, hours: &mut Hours) {
        self.hours += 1;
        self.not_a_number += u32::from(!(hour.energy + hour.bound).is_finite());
        hours.inside += u32::from((f64::from(hour.energy) - truth).abs() <= f64::from(hour.bound));
        hours.bounds[0].push(hour.bound);
        hours.bounds[1].extend((hour.silent == 0).then_some(hour.bound));
    }

    /// Refuses a quarter of a node that did not read, gave no number, or lost an image of its own.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        let Self { tier, storage, capacitance_f, stress, quarter, .. } = self;
        let counts = [
            (self.not_a_number, "hours without a number"),
            (self.frozen_hours, "hours without a reading"),
            (self.refused_images, "images refused"),
        ];
        match counts.into_iter().find(|(count, _)| *count > 0) {
            None => Ok(()),
            Some((count, what)) => Err(Failure::Step(format!(
                "{tier} on a {storage} of {capacitance_f} F, {stress:?}, quarter {quarter}: {count} {what}"
            ))),
        }
    }

    pub(super) fn next(self) -> Self {
        Self { quarter: self.quarter + 1, hours: 0, refused_images: 0, not_a_number: 0, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_has_its_share_inside_and_its_bound_over_that_of_the_first() {
        let (mut hours, mut quarter) = (Hours::default(), Quarter::default());
        let mut of = |bounds: [f32; 4]| {
            for bound in bounds {
                let silent = if bound > 5.0 { 60 } else { 0 };
                let hour = IncomeOfTime { seconds: 3600, energy: 1.0, bound, silent };
                quarter.count(hour, 0.0, &mut hours);
            }
            let closed = hours.close(quarter);
            quarter = quarter.next();
            [closed.inside, closed.bound_over_first, closed.resolved_over_first, closed.silent]
        };
        assert_eq!(of([9.0, 0.5, 2.0, 0.1]), [0.5, 1.0, 1.0, 0.25]);
        assert_eq!(of([3.0, 3.5, 0.0, 1.0]), [0.75, 1.5, 6.0, 0.0]);
    }
}
