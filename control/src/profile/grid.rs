//! The distances at which a speed profile is computed, and the curvature there.
//!
//! Every point of the path is a node: between two of them the curvature is linear. More nodes lie between points that are
//! far apart, and near a standstill, where the speed changes within centimetres.

use crate::Error;
use crate::plants::plant_model::model_error;
use steerwright_formats::Path;
use steerwright_models::files::path_geometry;

/// Largest distance between nodes, m, also as a share of a short path.
const SPACING: f64 = 0.5;
const SPACING_SHARE: f64 = 1.0 / 200.0;
/// Most nodes between the points of a path.
const MOST_NODES: f64 = 20_000.0;
/// Largest change of the curvature from a node to the next, as a share of it.
const SHARE_OF_CURVATURE: f64 = 0.15;
/// The interval beside a standstill is at most this share of the path.
const REST_SHARE: f64 = 1.0 / 16.0;
/// Near a standstill nodes are as far apart as this share of the distance to it.
const SHARE_NEAR_REST: f64 = 0.06;

/// Nodes along a path.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    /// Distances, m, increasing; of a closed path the last one is where the second lap begins.
    pub(super) distances: Vec<f64>,
    /// Curvature at the nodes, 1/m.
    pub(super) curvatures: Vec<f64>,
    /// Change of the curvature per distance from each node to the next, 1/m².
    pub(super) slopes: Vec<f64>,
    pub(super) is_closed: bool,
}

/// A place on the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// m.
    pub(super) distance: f64,
    /// 1/m.
    pub(super) curvature: f64,
    /// Change of the curvature per distance before and after it, 1/m²; 0 beyond an end.
    pub(super) slopes: [f64; 2],
}

impl Grid {
    /// Nodes along a path, with the lengths of the first and the last interval where the path begins or ends at standstill
    /// with a limited jerk, m. They are shorter where a point of the path lies nearer.
    /// Where a curvature above `tight` changes quickly, they are so close that it changes little from one to the next.
    pub(super) fn new(
        path: &Path,
        rest_lengths: [Option<f64>; 2],
        tight: f64,
    ) -> Result<Self, Error> {
        let geometry = path_geometry(path).map_err(model_error(&path.name))?;
        let (start, end) = (geometry.start(), geometry.end());
        let length = end - start;
        let spacing = SPACING.min(SPACING_SHARE * length).max(length / MOST_NODES);
        let mut breaks: Vec<f64> = path.points.iter().map(|point| point.distance_m).collect();
        if breaks[breaks.len() - 1] < end {
            breaks.push(end);
        }
        let share = REST_SHARE * length;
        let rests = rest_lengths.map(|rest| rest.map(|rest| rest.min(SPACING).min(share)));
        if let Some(rest) = rests[0]
            && start + rest < breaks[1]
        {
            breaks.insert(1, start + rest);
        }
        if let Some(rest) = rests[1]
            && end - rest > breaks[breaks.len() - 2]
        {
            breaks.insert(breaks.len() - 1, end - rest);
        }
        let largest = |distance: f64| {
            let mut largest = spacing;
            for (rest, away) in rests.into_iter().zip([distance - start, end - distance]) {
                if let Some(rest) = rest {
                    largest = largest.min(SHARE_NEAR_REST * away.max(rest));
                }
            }
            largest
        };
        let mut distances = vec![start];
        let last = breaks.len() - 2;
        for (k, pair) in breaks.windows(2).enumerate() {
            let (mut here, next) = (pair[0], pair[1]);
            let ends = [here, next].map(|distance| geometry.point_at(distance).curvature_per_m);
            let sharpest = ends[0].abs().max(ends[1].abs());
            let share = (ends[1] - ends[0]).abs() / sharpest.max(f64::MIN_POSITIVE);
            let closest = if sharpest > tight && share > SHARE_OF_CURVATURE {
                (next - here) * SHARE_OF_CURVATURE / share
            } else {
                f64::INFINITY
            };
            let is_rest = (k == 0 && rests[0].is_some()) || (k == last && rests[1].is_some());
            // What is left is shared, so that no node lies close to a point.
            while !is_rest && next > here {
                let step = largest(here).min(largest((here + spacing).min(next))).min(closest);
                let pieces = ((next - here) / step).ceil();
                if pieces <= 1.0 {
                    break;
                }
                here += (next - here) / pieces;
                distances.push(here);
            }
            distances.push(next);
        }
        let curvatures: Vec<f64> =
            distances.iter().map(|distance| geometry.point_at(*distance).curvature_per_m).collect();
        let mut grid = Self { distances, curvatures, slopes: Vec::new(), is_closed: path.closed };
        // Beyond its end an open path is straight, which is no change of curvature that anybody drives.
        let last = grid.curvatures.len() - 1;
        grid.curvatures[last] = if path.closed {
            grid.curvatures[0]
        } else {
            path.points.last().map_or(0.0, |point| point.curvature_per_m)
        };
        grid.slopes = (0..last)
            .map(|k| (grid.curvatures[k + 1] - grid.curvatures[k]) / grid.length(k))
            .collect();
        Ok(grid)
    }

    /// Distance from a node to the next, m.
    pub(super) fn length(&self, interval: usize) -> f64 {
        self.distances[interval + 1] - self.distances[interval]
    }

    /// The number of intervals between nodes.
    pub(super) fn intervals(&self) -> usize {
        self.slopes.len()
    }

    /// A node.
    pub(super) fn place(&self, node: usize) -> Place {
        Place {
            distance: self.distances[node],
            curvature: self.curvatures[node],
            slopes: self.slopes_at(node),
        }
    }

    /// The middle of an interval.
    pub(super) fn middle(&self, interval: usize) -> Place {
        let mean = |of: &[f64]| 0.5 * (of[interval] + of[interval + 1]);
        Place {
            distance: mean(&self.distances),
            curvature: mean(&self.curvatures),
            slopes: [self.slopes[interval]; 2],
        }
    }

    fn slopes_at(&self, node: usize) -> [f64; 2] {
        let last = self.intervals();
        let before = match node {
            0 if self.is_closed => self.slopes[last - 1],
            0 => 0.0,
            node => self.slopes[node - 1],
        };
        let after = match node {
            node if node < last => self.slopes[node],
            _ if self.is_closed => self.slopes[0],
            _ => 0.0,
        };
        [before, after]
    }
}
