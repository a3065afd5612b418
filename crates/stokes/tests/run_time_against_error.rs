//! The errors beside the times in `docs/run_time_against_error.csv` are those of the series, and the crate page quotes
//! this table. Times themselves are not tested.

use stokes::{Envelope, ModeWidth};

/// Of one row: source, width, order; L² error, error at zero, error of f32.
fn rows() -> Vec<(String, String, usize, [f64; 3])> {
    let table = include_str!("../../../docs/run_time_against_error.csv");
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = lines
        .next()
        .expect("the table has a header")
        .split(',')
        .collect();
    let place = |name: &str| {
        header
            .iter()
            .position(|known| *known == name)
            .expect("the header names the column")
    };
    let errors = ["l2_error", "error_at_zero", "f32_error"].map(place);
    let rows = lines
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|row| !row[place("source")].is_empty())
        .map(|row| {
            let text = |name: &str| row[place(name)].to_owned();
            let numbers = errors.map(|place| row[place].parse().expect("an error is a number"));
            (
                text("source"),
                text("width"),
                text("order").parse().expect("an order is a whole number"),
                numbers,
            )
        })
        .collect::<Vec<_>>();
    // five sources at thirteen orders, four tasks each
    assert_eq!(rows.len(), 5 * 13 * 4);
    rows
}

/// Over a shape of twice the variance a Gaussian's modes are a geometric series: ρ = (2 − 1)/(2 + 1) a pair of orders,
/// in the norm as well as, with alternating sign, at zero.
#[test]
fn a_gaussian_converges_geometrically() {
    for (source, _, order, [norm, at_zero, _]) in rows() {
        if source == "gaussian" {
            let k = order / 2 + 1;
            let expected = (1.0 / 3.0f64).powi(k as i32);
            let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
            // ten digits are written; the coefficients carry rounding of the order of ε each
            let limit = 1e-9 * expected + 100.0 * f64::EPSILON;
            assert!(
                (norm - expected).abs() < limit,
                "{order}: {norm:e}, expected {expected:e}"
            );
            assert!(
                (at_zero - sign * expected).abs() < limit,
                "{order}: {at_zero:e}"
            );
        }
    }
}

/// A table that was computed outside this repository, to its digits: disk of radius 2 σ, L² error and error of f(0).
#[test]
fn a_disk_converges_as_the_table_says() {
    for (order, norm, at_zero) in [
        (0, 0.50, -0.135),
        (4, 0.32, -0.030),
        (16, 0.24, -0.044),
        (64, 0.17, -0.002),
    ] {
        let (.., found) = rows()
            .into_iter()
            .find(|(source, width, n, _)| {
                source == "disk" && width == "variance matched" && *n == order
            })
            .unwrap();
        assert!((found[0] - norm).abs() <= 0.5e-2, "{order}: {}", found[0]);
        assert!(
            (found[1] - at_zero).abs() <= 0.5e-3,
            "{order}: {}",
            found[1]
        );
    }
}

#[test]
fn the_table_is_not_older_than_the_code() {
    let rectangle = Envelope::rectangle(1.0, 1.0).unwrap();
    let disk = Envelope::disk(1.0).unwrap();
    for (source, width, order, [norm, at_zero, _]) in rows() {
        let envelope = match source.as_str() {
            "rectangle" => &rectangle,
            "disk" => &disk,
            _ => continue,
        };
        let width = match width.as_str() {
            "variance matched" => ModeWidth::VarianceMatched,
            "half-width 4 σ" => ModeWidth::Sigmas(4.0),
            other => panic!("width '{other}'"),
        };
        let modes = envelope.modes(width, order).unwrap();
        // ten digits are written
        assert!(
            (modes.relative_error() - norm).abs() < 1e-9,
            "{source} {order}: {norm}"
        );
        let expected = modes.sum_at_zero() / modes.area() - 1.0;
        assert!(
            (expected - at_zero).abs() < 1e-9,
            "{source} {order}: {at_zero}"
        );
    }
}

/// Rounding of coefficients, modes and sums in f32: a few ε of the function, growing slowly with the order.
#[test]
fn single_precision_is_good_to_a_millionth() {
    for (source, width, order, [.., f32]) in rows() {
        // random signs: √(terms) of half a unit each, at least a few
        let limit = (4.0 + (order as f64).sqrt()) * f64::from(f32::EPSILON);
        assert!(
            f32 < limit,
            "{source} {width} {order}: {f32:e}, limit {limit:e}"
        );
    }
}

#[test]
fn the_crate_page_quotes_the_table() {
    let csv = include_str!("../../../docs/run_time_against_error.csv");
    // of the rows that begin so: the column, as a number
    let find = |start: &str, column: usize| -> f64 {
        let row = csv.lines().find(|line| line.starts_with(start));
        let cells: Vec<_> = row
            .unwrap_or_else(|| panic!("no row '{start}'"))
            .split(',')
            .collect();
        cells[column].parse().expect("a number")
    };
    let quoted = include_str!("../src/lib.rs").lines().filter_map(|line| {
        let cells: Option<Vec<f64>> = line
            .strip_prefix("//! | ")?
            .trim_end_matches('|')
            .split('|')
            .map(|cell| cell.trim().parse().ok())
            .collect();
        cells
    });
    let mut rows = 0;
    for row in quoted {
        let order = row[0];
        let (ns, l2) = (4, 10);
        let expected = [
            find(&format!("evaluate f64,gaussian,variance × 2,{order},"), ns),
            find(
                &format!("evaluate f32 16 points,gaussian,variance × 2,{order},"),
                ns,
            ),
            find(&format!("project,rectangle,half-width 4 σ,{order},"), ns) * 1e-3,
            find(&format!("project,gaussian,variance × 2,{order},"), l2),
            find(&format!("project,rectangle,half-width 4 σ,{order},"), l2),
        ];
        for (quoted, expected) in row[1..].iter().zip(expected) {
            // two digits or more: half a unit of the second is 5 % at most
            assert!(
                (quoted / expected - 1.0).abs() <= 0.05,
                "{order}: {quoted} {expected}"
            );
        }
        assert_eq!(row.len(), 6, "order {order}");
        rows += 1;
    }
    assert_eq!(rows, 7);
}
