//! Diffuse lobes of a relief as sums of Gaussians, tabulated over the phase variance g.
//!
//! ```text
//! R(x) = e^(−g) + (1 − e^(−g)) Σ w_j e^(−m_j x²/(2D²)),   Σ w_j = 1
//! ```
//!
//! A row of the table holds the w_j and the rates m_j over a mean rate h, `1/h = Σ w_j/m_j`. Between two rows both lobes
//! are drawn with the interpolated h, so that the peak of the lobe is that of the cubic through ln h.
//!
//! Accuracy: each row keeps [`TOLERANCE`] of its largest value; between rows the shape, of which h is taken out, changes
//! by less than that in the second order. In far tails the relative error is larger.

use mueller16::{AutocorrelationError, Relief, Tolerance};

/// Error of a row, over the largest value of the lobe.
pub(super) const TOLERANCE: f64 = 5e-4;

/// Least g of the table: below, the lobe is that of single scattering, which errs by g/4.
const LEAST: f64 = 1e-3;

/// Rows for each doubling of g.
const PER_OCTAVE: f64 = 4.0;

/// One Gaussian.
#[derive(Clone, Copy, Debug)]
struct Term {
    weight: f32,
    /// Rate over the row's mean rate.
    rate: f32,
}

#[derive(Clone, Debug)]
struct Row {
    ln_rate: f32,
    /// Rate by which the lobe bends at its top, over the mean rate.
    narrow: f32,
    terms: Vec<Term>,
}

/// The lobes of a relief for all g.
#[derive(Clone, Debug)]
pub(super) struct Lobes {
    rows: Vec<Row>,
}

/// The lobe for one g: of light whose tangential wave vector is `p/D`, D the correlation root of the relief.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe<'a> {
    rows: [&'a Row; 2],
    /// Share of the second row.
    blend: f32,
    /// Mean rate.
    rate: f32,
}

impl Lobes {
    /// The table of a relief with heights of standard `deviation`, m, up to the phase variance `largest`.
    pub(super) fn new(
        relief: &impl Relief,
        deviation: f64,
        largest: f64,
    ) -> Result<Self, AutocorrelationError> {
        let tolerance = Tolerance::relative(TOLERANCE).unwrap_or(Tolerance::ROUNDING);
        let count = ((largest / LEAST).log2() * PER_OCTAVE).ceil() as u32 + 1;
        let row = |index: u32| {
            let g = LEAST * (f64::from(index) / PER_OCTAVE).exp2();
            let (r, _) = relief.autocorrelation(g.sqrt() / deviation, tolerance)?;
            let r = r.without_deltas();
            let terms = || {
                r.families()
                    .iter()
                    .flat_map(mueller16::GaussianFamily::terms)
            };
            let sum = |f: &dyn Fn(f64) -> f64| terms().map(|t| t.weight * f(t.rate)).sum::<f64>();
            let (all, area) = (sum(&|_| 1.0), sum(&|m| m.recip()));
            let (rate, bend) = (all / area, area / sum(&|m| (m * m).recip()));
            let peak = |weight: f64, m: f64| weight / (m * area);
            let mut terms: Vec<Term> = terms()
                // what neither the top of the lobe nor its power notices
                .filter(|t| peak(t.weight, t.rate).max(t.weight / all) > 1e-6)
                .map(|t| Term {
                    weight: (t.weight / all) as f32,
                    rate: (t.rate / rate) as f32,
                })
                .collect();
            let kept: f32 = terms.iter().map(|t| t.weight).sum();
            for term in &mut terms {
                term.weight /= kept;
            }
            Ok::<_, AutocorrelationError>(Row {
                ln_rate: rate.ln() as f32,
                narrow: (bend / rate) as f32,
                terms,
            })
        };
        Ok(Self {
            rows: (0..count.max(8)).map(row).collect::<Result<_, _>>()?,
        })
    }

    /// Number of Gaussians in the longest row.
    pub(super) fn most_terms(&self) -> usize {
        let lengths = self.rows.iter().map(|row| row.terms.len());
        lengths.max().unwrap_or(0)
    }

    /// The lobe for one g.
    #[inline]
    pub(super) fn at(&self, g: f32) -> Lobe<'_> {
        let last = self.rows.len() - 1;
        let place = (g.max(1e-30) / LEAST as f32).log2() * PER_OCTAVE as f32;
        if place <= 0.0 {
            return self.row(0, 0.0, self.rows[0].ln_rate);
        }
        if place >= last as f32 {
            // a power law from here on, as over the last doubling
            let octave = PER_OCTAVE as usize;
            let (from, to) = (self.rows[last - octave].ln_rate, self.rows[last].ln_rate);
            let slope = (to - from) / octave as f32;
            return self.row(last, 0.0, to + slope * (place - last as f32));
        }
        let index = (place as usize).min(last - 1);
        let t = place - index as f32;
        let ln = |i: usize| self.rows[i].ln_rate;
        let after = if index + 2 > last {
            2.0 * ln(last) - ln(last - 1)
        } else {
            ln(index + 2)
        };
        // Catmull and Rom's cubic
        let (a, b, c, d) = (ln(index.max(1) - 1), ln(index), ln(index + 1), after);
        let ln_rate = b + 0.5
            * t
            * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
        self.row(index, t, ln_rate)
    }

    fn row(&self, index: usize, blend: f32, ln_rate: f32) -> Lobe<'_> {
        Lobe {
            rows: [
                &self.rows[index],
                &self.rows[(index + 1).min(self.rows.len() - 1)],
            ],
            blend,
            rate: ln_rate.exp(),
        }
    }
}

impl Lobe<'_> {
    /// `Σ w/√((m + c₁)(m + c₂)) e^(−p₁²/2(m + c₁) − p₂²/2(m + c₂))`: the lobe over `2πD²`, averaged over Gaussian
    /// directions whose covariance in p is `diag(c)`.
    #[inline]
    pub(super) fn value(&self, p: [f32; 2], c: [f32; 2]) -> f32 {
        let [p1, p2] = p.map(|p| 0.5 * p * p);
        let sum = |row: &Row| {
            let mut sum = 0.0;
            for term in &row.terms {
                let m = term.rate * self.rate;
                let (a, b) = (m + c[0], m + c[1]);
                sum += term.weight * (-p1 / a - p2 / b).exp() / (a * b).sqrt();
            }
            sum
        };
        let first = sum(self.rows[0]);
        if self.blend == 0.0 {
            return first;
        }
        first + self.blend * (sum(self.rows[1]) - first)
    }

    /// Mean rate h: `1/h = Σ w/m`.
    #[inline]
    pub(super) fn rate(&self) -> f32 {
        self.rate
    }

    /// Rate of the Gaussian that bends like the lobe at its top.
    #[inline]
    pub(super) fn narrowest(&self) -> f32 {
        let [a, b] = self.rows.map(|row| row.narrow);
        self.rate * a.min(b)
    }

    /// The rate m of a Gaussian, drawn by the weights; `u` is uniform and left so.
    #[inline]
    pub(super) fn draw(&self, u: &mut f32) -> f32 {
        let row = if super::choose(u, self.blend) {
            self.rows[1]
        } else {
            self.rows[0]
        };
        let mut below = 0.0;
        for term in &row.terms {
            if *u < below + term.weight {
                *u = (*u - below) / term.weight;
                return term.rate * self.rate;
            }
            below += term.weight;
        }
        row.terms.last().map_or(1.0, |t| t.rate) * self.rate
    }
}
