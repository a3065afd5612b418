//! The ratio of diffuse light to what is not in the mirror, tabulated over the angle of incidence.

use super::error::SurfaceError;
use super::hemisphere::Hemisphere;
use crate::relief::Relief;

/// Least cosine in a table; below it `ln A` goes on as a line in `ln cos`.
const LEAST: f64 = 1e-3;
/// Intervals of `ln cos` to begin with.
const INTERVALS: usize = 6;
/// How often each is halved, whatever its middle says: what rises above 1 between two nodes is to be found.
const COARSE: usize = 1;
/// How often one is halved at most.
const DEEPEST: usize = 6;

/// `ln A` over `ln cos`, interpolated by cubics that are monotone where the values are.
///
/// Source: Fritsch and Carlson 1980, Monotone Piecewise Cubic Interpolation, with the slopes of Fritsch and Butland 1984.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    /// `ln cos`, increasing to 0.
    x: Vec<f64>,
    /// `ln A`
    y: Vec<f64>,
    slopes: Vec<f64>,
    /// Relative, the largest found in the middle of an interval before that became a node.
    pub(super) error: f64,
}

impl Table {
    pub(super) fn new<R: Relief>(hemisphere: &Hemisphere<'_, R>) -> Result<Self, SurfaceError> {
        // a surface without diffuse light has A = 0
        let value = |x: f64| Ok::<_, SurfaceError>(hemisphere.ratio(x.exp())?.max(1e-300).ln());
        let mut nodes = vec![];
        for step in 0..=INTERVALS {
            let x = LEAST.ln() * (1.0 - step as f64 / INTERVALS as f64);
            nodes.push((x, value(x)?, true));
        }
        let mut error: f64 = 0.0;
        for depth in 0..=DEEPEST {
            let table = Self::of(&nodes);
            let mut finer = vec![nodes[0]];
            let mut worst: f64 = 0.0;
            for pair in nodes.windows(2) {
                let ((a, _, _), (b, last, open)) = (pair[0], pair[1]);
                if open {
                    let middle = 0.5 * (a + b);
                    let exact = value(middle)?;
                    // where the cap is idle on both sides A need not be known
                    let off = (table.log_value(middle).max(0.0) - exact.max(0.0)).abs();
                    let again = depth < COARSE || (off > hemisphere.tolerance && depth < DEEPEST);
                    worst = worst.max(off);
                    if !again {
                        error = error.max(off);
                    }
                    finer.push((middle, exact, again));
                    finer.push((b, last, again));
                } else {
                    finer.push((b, last, false));
                }
            }
            nodes = finer;
            if depth >= COARSE && worst <= hemisphere.tolerance {
                break;
            }
        }
        let mut table = Self::of(&nodes);
        table.error = error.exp_m1();
        Ok(table)
    }

    fn of(nodes: &[(f64, f64, bool)]) -> Self {
        let x: Vec<f64> = nodes.iter().map(|n| n.0).collect();
        let y: Vec<f64> = nodes.iter().map(|n| n.1).collect();
        let secants: Vec<f64> = (1..x.len())
            .map(|i| (y[i] - y[i - 1]) / (x[i] - x[i - 1]))
            .collect();
        let last = secants.len();
        let slopes = (0..=last)
            .map(|i| {
                if i == 0 || i == last {
                    return secants[i.min(last - 1)];
                }
                let (left, right) = (secants[i - 1], secants[i]);
                if left * right <= 0.0 {
                    return 0.0;
                }
                let (h1, h2) = (x[i] - x[i - 1], x[i + 1] - x[i]);
                let (w1, w2) = (2.0 * h2 + h1, h2 + 2.0 * h1);
                (w1 + w2) / (w1 / left + w2 / right)
            })
            .collect();
        Self {
            x,
            y,
            slopes,
            error: 0.0,
        }
    }

    pub(super) fn value(&self, cosine: f64) -> f64 {
        self.log_value(cosine.max(f64::MIN_POSITIVE).ln().min(0.0))
            .exp()
    }

    fn log_value(&self, at: f64) -> f64 {
        let (x, y) = (&self.x, &self.y);
        if at <= x[0] {
            return y[0] + self.slopes[0] * (at - x[0]);
        }
        let i = x.partition_point(|node| *node < at).clamp(1, x.len() - 1);
        let h = x[i] - x[i - 1];
        let t = (at - x[i - 1]) / h;
        let (one, back) = (t * t * (3.0 - 2.0 * t), 1.0 - t);
        y[i - 1] * (1.0 - one)
            + y[i] * one
            + h * t * back * (self.slopes[i - 1] * back - self.slopes[i] * t)
    }
}
