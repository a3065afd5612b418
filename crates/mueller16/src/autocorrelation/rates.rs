//! Positive measures of rates: what a positive mixture of Gaussians `Σ w e^(−m u²/2)` is beside its root.
//!
//! The product of two mixtures is the convolution of their measures, `w w'` at `m + m'`. The number of points is held by
//! gathering: the line of rates is cut into bins of ratio 2, and the points of a bin become the nodes of the Gauss
//! quadrature of their weights. n nodes keep the bin's first 2n moments, positive weights and rates within the bin; from m
//! to 2m the mixture then errs by at most `4 (m w/4)^(2n) e^(−m w)/(2n)!` of the bin's weight at `w = u²/2`. Where `m w` is
//! small that is next to nothing: a mixture that is squared again and again keeps what matters to the result.

use nalgebra::DMatrix;

/// A point `[rate, weight]`.
pub(super) type Point = [f64; 2];

/// `ln` of the ratio of a bin's ends.
const BIN: f64 = std::f64::consts::LN_2;

/// Most points of a bin.
const MOST: usize = 12;

/// The error that gathering may make of the mixture in which it ends.
#[derive(Clone, Copy)]
pub(super) struct Budget<'a> {
    /// Of the last mixture's lobe, over its largest value.
    pub(super) tolerance: f64,
    /// Bound on the lobe of a Gaussian of the rate m and the weight 1 over that lobe.
    pub(super) share: &'a dyn Fn(f64) -> f64,
    /// `u²/2` beyond which less than the tolerance of that lobe lies.
    pub(super) end: f64,
    /// How often the points enter the last mixture: the power to which this one is raised.
    pub(super) times: f64,
}

impl Budget<'_> {
    /// The number of points for a bin of the rates m to 2 m and this weight.
    ///
    /// The mixture errs by at most `4 (m w/4)^(2n) e^(−m w)/(2n)!` of the weight at `w = u²/2`, which is largest at
    /// `m w = 2n` or at the end of the last mixture, and its lobe by no more than the bin's own.
    fn points(&self, m: f64, weight: f64) -> usize {
        let end = m * self.end;
        let share = self.times * weight * (self.share)(m);
        let mut factorial = 1.0;
        for n in 1..MOST {
            let order = 2.0 * n as f64;
            factorial *= order * (order - 1.0);
            let x = end.min(order);
            if share * 4.0 * (0.25 * x).powf(order) * (-x).exp() / factorial <= self.tolerance {
                return n;
            }
        }
        MOST
    }
}

/// Less than this share of the weight and of the lobe at 0 is dropped.
const NOTHING: f64 = 1e-20;

/// The points of each bin gathered to as many as `count` says of its least rate and its weight.
pub(super) fn gathered(points: &[Point], count: impl Fn(f64, f64) -> usize) -> Vec<Point> {
    let weight: f64 = points.iter().map(|[_, w]| w).sum();
    let lobe: f64 = points.iter().map(|[m, w]| w / m).sum();
    let counts = |&&[m, w]: &&Point| w > NOTHING * weight || w / m > NOTHING * lobe;
    let kept = || points.iter().filter(counts);
    let bin_of = |m: f64| (m.ln() / BIN).floor() as i64;
    let Some(first) = kept().map(|[m, _]| bin_of(*m)).min() else {
        return vec![];
    };
    let mut bins: Vec<Vec<Point>> = vec![];
    for &[m, w] in kept() {
        let place = usize::try_from(bin_of(m) - first).unwrap_or(0);
        if place >= bins.len() {
            bins.resize_with(place + 1, Vec::new);
        }
        bins[place].push([m, w]);
    }
    let gathered = bins.iter().enumerate().flat_map(|(place, bin)| {
        let least = ((first + place as i64) as f64 * BIN).exp();
        gauss(bin, count(least, bin.iter().map(|[_, w]| w).sum()))
    });
    gathered.collect()
}

/// The Gauss quadrature of a discrete measure: the points themselves where there are no more than nodes.
///
/// Source: Gautschi, Orthogonal Polynomials: Computation and Approximation, sections 2.2.3.1 (Stieltjes) and 3.1.1.1.
fn gauss(points: &[Point], nodes: usize) -> Vec<Point> {
    if points.len() <= nodes {
        return points.to_vec();
    }
    let total: f64 = points.iter().map(|[_, w]| w).sum();
    let mean = points.iter().map(|[m, w]| m * (w / total)).sum::<f64>();
    let half = points
        .iter()
        .map(|[m, _]| (m - mean).abs())
        .fold(0.0, f64::max);
    if half <= 1e-14 * mean {
        return vec![[mean, total]];
    }
    let xs: Vec<f64> = points.iter().map(|[m, _]| (m - mean) / half).collect();
    // monic orthogonal polynomials, each scaled to unit norm
    let mut now = vec![1.0; points.len()];
    let mut last = vec![0.0; points.len()];
    let mut jacobi = DMatrix::zeros(nodes, nodes);
    let (mut size, mut across) = (0, 0.0);
    let weighted = |p: &[f64], x: &dyn Fn(usize) -> f64| -> f64 {
        let terms = points.iter().zip(p).enumerate();
        terms.map(|(i, ([_, w], p))| w / total * p * p * x(i)).sum()
    };
    while size < nodes {
        let alpha = weighted(&now, &|i| xs[i]);
        jacobi[(size, size)] = alpha;
        size += 1;
        for (i, x) in xs.iter().enumerate() {
            let next = (x - alpha) * now[i] - across * last[i];
            last[i] = now[i];
            now[i] = next;
        }
        across = weighted(&now, &|_| 1.0).sqrt();
        // what is left is rounding: the measure has no more points
        if size == nodes || across < 1e-12 {
            break;
        }
        now.iter_mut().for_each(|p| *p /= across);
        jacobi[(size, size - 1)] = across;
        jacobi[(size - 1, size)] = across;
    }
    let eigen = jacobi.resize(size, size, 0.0).symmetric_eigen();
    (0..size)
        .map(|i| {
            let first = eigen.eigenvectors[(0, i)];
            [mean + half * eigen.eigenvalues[i], total * first * first]
        })
        .collect()
}

/// The measure of the product of two mixtures.
fn product<'a>(a: &'a [Point], b: &'a [Point]) -> impl Iterator<Item = Point> + 'a {
    a.iter()
        .flat_map(|[m, w]| b.iter().map(move |[n, v]| [m + n, w * v]))
}

/// The measure of the square of a mixture: each pair once.
fn square(a: &[Point]) -> impl Iterator<Item = Point> + '_ {
    a.iter().enumerate().flat_map(|(i, [m, w])| {
        let pairs = a[i..].iter().enumerate();
        pairs.map(move |(j, [n, v])| [m + n, if j == 0 { w * v } else { 2.0 * w * v }])
    })
}

fn scaled(points: &[Point], by: f64) -> impl Iterator<Item = Point> + '_ {
    points.iter().map(move |[m, w]| [*m, w * by])
}

/// The same rates with weights that add up to `total`.
fn normalized(points: &[Point], total: f64) -> Vec<Point> {
    let weight: f64 = points.iter().map(|[_, w]| w).sum();
    scaled(points, total / weight).collect()
}

/// What is left of a compound Poisson law besides its atom at 0, of weight `e^(−g)`: the measure of
/// `e^(−g(1−ρ)) − e^(−g)` for the mixture ρ of `jumps`, whose weights add up to 1.
///
/// The budget is that of the result.
///
/// The first `g/2^J ≤ 1/8` is the Poisson sum, nested as `μ = a ρ (1 + a/2 ρ (1 + a/3 ρ …))`; J squares follow.
pub(super) fn compound_poisson(jumps: &[Point], g: f64, result: &Budget<'_>) -> Vec<Point> {
    let doublings = (8.0 * g).log2().ceil().max(0.0);
    let a = g / doublings.exp2();
    let gather = |points: &[Point], times: f64| {
        let times = times * result.times;
        let budget = Budget { times, ..*result };
        gathered(points, |m, weight| budget.points(m, weight))
    };
    // the first power that is left out, of which all squares have `2^J`
    let (mut powers, mut rest) = (1.0, a / 2.0);
    while rest * doublings.exp2() > result.tolerance {
        powers += 1.0;
        rest *= a / (powers + 1.0);
    }
    let times = doublings.exp2();
    let jumps = gather(&scaled(jumps, a).collect::<Vec<_>>(), times);
    let mut sum: Vec<Point> = scaled(&jumps, 1.0 / powers).collect();
    while powers > 1.0 {
        powers -= 1.0;
        let nested: Vec<Point> = product(&jumps, &sum).chain(jumps.iter().copied()).collect();
        sum = scaled(&gather(&nested, times), 1.0 / powers).collect();
    }
    // the weight that belongs to the power left out goes to all
    sum = normalized(&sum, -(-a).exp_m1());
    let mut atom = (-a).exp();
    for j in 1..=doublings as i32 {
        let all: Vec<Point> = square(&sum).chain(scaled(&sum, 2.0 * atom)).collect();
        sum = gather(&all, (doublings - f64::from(j)).exp2());
        atom *= atom;
    }
    normalized(&sum, -(-g).exp_m1())
}
