//! Spikes of a channel, found in rows that may come in chunks: every row is seen with its neighbours.

use super::series::Series;
use crate::validation::{Jumps, NEIGHBOURS};
use std::rc::Rc;

/// Leaves spikes out.
#[derive(Default)]
pub(super) struct SpikeFilter {
    /// The last rows seen: those already passed on, then those that wait for their neighbours.
    held: Vec<(f64, f64, u64)>,
    /// How many of them have been passed on.
    passed: usize,
    /// Those that are samples of spikes.
    left_out: Vec<usize>,
    /// What the channel usually does.
    jumps: Option<Jumps>,
}

impl SpikeFilter {
    /// Replaces the rows that follow by those that are decided upon, and adds the spikes' instants. The
    /// last rows wait for those after them, unless these `are_last`.
    pub(super) fn take(&mut self, series: &mut Series, are_last: bool) {
        if !self.held.is_empty() {
            let held = std::mem::take(&mut self.held);
            Rc::make_mut(&mut series.time).splice(0..0, held.iter().map(|row| row.0));
            series.value.splice(0..0, held.iter().map(|row| row.1));
            Rc::make_mut(&mut series.line).splice(0..0, held.iter().map(|row| row.2));
        }
        let (rows, passed) = (series.value.len(), self.passed);
        let end = if are_last { rows } else { rows.saturating_sub(NEIGHBOURS).max(passed) };
        // The last rows of a file may be too few to say what is usual.
        if let Some(jumps) = Jumps::of(&series.time, &series.value)
            && self.jumps.is_none_or(|earlier| 2 * jumps.count >= earlier.count)
        {
            self.jumps = Some(jumps);
        }
        let mut left_out = std::mem::take(&mut self.left_out);
        if let Some(jumps) = self.jumps {
            let found = jumps.spikes(&series.time, &series.value).into_iter();
            for spike in found.filter(|spike| (passed..end).contains(&spike.start)) {
                series.spikes.extend(spike.clone().map(|i| series.time[i]));
                left_out.extend(spike);
            }
        }
        let from = end.saturating_sub(NEIGHBOURS);
        if !are_last {
            self.held =
                (from..rows).map(|i| (series.time[i], series.value[i], series.line[i])).collect();
            self.passed = end - from;
            self.left_out = left_out.iter().filter_map(|i| i.checked_sub(from)).collect();
        }
        let left_out: std::collections::HashSet<usize> = left_out.into_iter().collect();
        series.retain(|i| (passed..end).contains(&i) && !left_out.contains(&i));
    }
}
