//! Integrals of smooth functions with peaks at known places.

/// Nodes of Gauss and Kronrod on −1..1, the positive half and 0.
///
/// Source: Piessens et al., QUADPACK, 1983, routine QK15.
const NODES: [f64; 8] = [
    0.991455371120812639206854697526329,
    0.949107912342758524526189684047851,
    0.864864423359769072789712788640926,
    0.741531185599394439863864773280788,
    0.586087235467691130294144691693829,
    0.405845151377397166906606412076961,
    0.207784955007898467600689403773245,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022935322010529224963732008058970,
    0.063092092629978553290700663189204,
    0.104790010322250183839876322541518,
    0.140653259715525918745189590510238,
    0.169004726639267902826583426598550,
    0.190350578064785409913256402421014,
    0.204432940075298892414161999234649,
    0.209482141084727828012999174891714,
];
/// Weights of Gauss at every second node, from the second on.
const GAUSS: [f64; 4] = [
    0.129484966168869693270611432679082,
    0.279705391489276667901467771423780,
    0.381830050505118944950369775488975,
    0.417959183673469387755102040816327,
];
/// An interval is halved so often at most: beyond it the integrand is not smooth.
const DEEPEST: usize = 12;

/// The integral of `f` over the panels between successive `edges`, each halved until the two rules agree to `relative` of
/// its own value or `absolute`.
///
/// The difference of the two rules is the error of the coarser one; that of the result is far below it.
pub(super) fn integrate<E>(
    f: &mut dyn FnMut(f64) -> Result<f64, E>,
    edges: &[f64],
    relative: f64,
    absolute: f64,
) -> Result<f64, E> {
    let mut sum = 0.0;
    for pair in edges.windows(2) {
        sum += panel(f, [pair[0], pair[1]], relative, absolute, 0)?;
    }
    Ok(sum)
}

fn panel<E>(
    f: &mut dyn FnMut(f64) -> Result<f64, E>,
    [from, to]: [f64; 2],
    relative: f64,
    absolute: f64,
    depth: usize,
) -> Result<f64, E> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut fine, mut coarse) = (0.0, 0.0);
    for (place, (&x, &w)) in NODES.iter().zip(&KRONROD).enumerate() {
        let value = if x == 0.0 {
            f(middle)?
        } else {
            f(middle - half * x)? + f(middle + half * x)?
        };
        fine += w * value;
        if place % 2 == 1 {
            coarse += GAUSS[place / 2] * value;
        }
    }
    let error = ((fine - coarse) * half).abs();
    if error <= absolute.max(relative * (fine * half).abs()) || depth == DEEPEST {
        return Ok(fine * half);
    }
    let below = panel(f, [from, middle], relative, absolute, depth + 1)?;
    Ok(below + panel(f, [middle, to], relative, absolute, depth + 1)?)
}

/// Edges from `low` to `high` that grow by a factor of 2 from both sides of `peak`, the first ones `width` wide.
pub(super) fn graded(low: f64, high: f64, peak: f64, width: f64) -> Vec<f64> {
    let peak = peak.clamp(low, high);
    let mut edges = vec![low, peak, high];
    let mut step = width.max(1e-12 * (high - low));
    while step < high - low {
        edges.extend(
            [peak - step, peak + step]
                .into_iter()
                .filter(|e| (low..=high).contains(e)),
        );
        step *= 2.0;
    }
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn over(f: impl Fn(f64) -> f64, edges: &[f64], relative: f64) -> f64 {
        let mut f = |x| Ok::<_, Infallible>(f(x));
        match integrate(&mut f, edges, relative, 0.0) {
            Ok(value) => value,
            Err(never) => match never {},
        }
    }

    #[test]
    fn polynomials_up_to_degree_22_are_exact() {
        // 15 nodes of Kronrod; an error of 1e-15 in a node of weight w would be seen as 44 w 1e-15 at most
        for degree in [0, 2, 8, 22] {
            let found = over(|x| x.powi(degree), &[-1.0, 1.0], 1.0);
            let exact = 2.0 / f64::from(degree + 1);
            assert!((found - exact).abs() < 2e-14, "{degree}: {found} {exact}");
        }
    }

    #[test]
    fn a_narrow_peak_at_a_known_place_is_found() {
        let (at, width) = (0.3, 1e-7);
        let gaussian = |x: f64| (-0.5 * ((x - at) / width).powi(2)).exp();
        let found = over(gaussian, &graded(0.0, 2.0, at, width), 1e-10);
        let exact = width * std::f64::consts::TAU.sqrt();
        assert!((found / exact - 1.0).abs() < 1e-10);
    }

    #[test]
    fn a_corner_is_halved_into() {
        let found = over(|x| (x - 0.377).abs(), &[0.0, 1.0], 1e-9);
        let exact = 0.5 * (0.377f64.powi(2) + 0.623f64.powi(2));
        assert!((found - exact).abs() < 1e-8);
    }
}
