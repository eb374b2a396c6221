//! The open question: does uniform yarn over-predict about twofold near the ballistic limit of the sheet held at its
//! corners? The ratio uniform/stochastic over everything that the paper leaves open.

use super::plan::{self, Effort, Point, Yarn};
use fabric::AttachmentKind::FourCorners;

/// An ensemble of the map.
fn point(effort: Effort, washer: usize, yarn: Yarn, energy: f64) -> Point {
    Point { washer, ..plan::small(effort, FourCorners, yarn, energy) }
}

/// Every ensemble of the map.
pub fn points(effort: Effort) -> Vec<Point> {
    let mut points = Vec::new();
    for washer in 0..effort.washers() {
        for yarn in [Yarn::Stochastic, Yarn::Uniform] {
            points.extend(effort.map_energies().iter().map(|&energy| point(effort, washer, yarn, energy)));
        }
    }
    points
}
