//! The page of the crate quotes the times of `docs/interaction_run_time.csv`, and the errors beside them are what they
//! should be. Times themselves are not tested.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

struct Row {
    part: String,
    name: String,
    order: usize,
    terms: usize,
    number: String,
    least: f64,
    truncation: Option<f64>,
    rounding: Option<f64>,
}

fn rows() -> Vec<Row> {
    let table = include_str!("../../../docs/interaction_run_time.csv");
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<_> = lines.next().expect("a header").split(',').collect();
    let place = |name| header.iter().position(|known| *known == name).unwrap();
    lines
        .map(|line| {
            let cells: Vec<_> = line.split(',').collect();
            assert_eq!(cells.len(), header.len(), "{line}");
            let text = |name| cells[place(name)].to_owned();
            Row {
                part: text("part"),
                name: text("name"),
                order: text("order").parse().unwrap(),
                terms: text("terms").parse().unwrap(),
                number: text("number"),
                least: text("least_ns").parse().unwrap(),
                truncation: text("truncation").parse().ok(),
                rounding: text("rounding").parse().ok(),
            }
        })
        .collect()
}

#[test]
fn the_documentation_quotes_the_table() {
    let rows = rows();
    let mut quoted = 0;
    for line in include_str!("../src/theorem.rs").lines() {
        let Some(line) = line.trim().strip_prefix("/// | ") else {
            continue;
        };
        let cells: Vec<_> = line.trim_end_matches(" |").split(" | ").collect();
        // other tables have other columns
        let [part, name, order, ns] = cells[..] else {
            continue;
        };
        let (Ok(order), Ok(ns)) = (order.parse::<usize>(), ns.parse::<f64>()) else {
            continue;
        };
        let row = rows
            .iter()
            .find(|row| row.part == part && row.name == name && row.order == order)
            .unwrap_or_else(|| panic!("no row '{line}'"));
        // whole nanoseconds are written
        assert!((row.least - ns).abs() <= 0.5, "{line}: {}", row.least);
        quoted += 1;
    }
    assert_eq!(quoted, 10);
}

/// The two-dimensional Gaussian over a shape of twice its variance: a geometric series of ratio 1/3 for two orders.
#[test]
fn series_converge_at_the_rate_of_their_source() {
    let rows = rows();
    for name in ["series; g = 10", "series; g = 1e4"] {
        let error = |order| {
            let found = rows.iter().find(|r| r.name == name && r.order == order);
            found.and_then(|row| row.truncation).unwrap()
        };
        for [short, long] in [[4, 8], [8, 16], [16, 32]] {
            let rate = (error(long) / error(short)).powf(2.0 / (long - short) as f64);
            // a factor linear in the order stands before the power: (1 + long)/(1 + short) < 2
            let [low, high] = [0.5, 2.0].map(|f: f64| f.powf(2.0 / (long - short) as f64) / 3.0);
            assert!(
                (low..=high).contains(&rate),
                "{name} {short} {long}: {rate}"
            );
        }
    }
}

#[test]
fn single_precision_and_tolerances_keep_their_word() {
    let mut count = 0;
    for row in rows() {
        let (error, limit) = match row.part.as_str() {
            "order" if row.number == "f32" => (row.rounding, 2e-5),
            // of the peak of each order's own lobe, and of Σ|c_ab| (at most 2.5 at order 4), summed over 43 lobes
            "grating" => match row.name.strip_prefix("orders within ") {
                Some(tolerance) => (
                    row.truncation,
                    43.0 * 2.5 * tolerance.parse::<f64>().unwrap(),
                ),
                None => continue,
            },
            _ => continue,
        };
        assert!(error.unwrap() <= limit, "{} {}", row.name, row.order);
        count += 1;
    }
    assert_eq!(count, 18 + 6);
}

/// Beckmann's lobe is off by 1/g of the peak at most; more Gaussians are never worse.
#[test]
fn rough_surfaces_tend_to_their_limit() {
    for (name, g) in [("g = 100", 1e2), ("g = 1000", 1e3), ("g = 1e4", 1e4)] {
        let rows = rows();
        let lines: Vec<_> = rows
            .iter()
            .filter(|row| row.part == "rough" && row.name == name)
            .collect();
        let (limit, sums) = lines.split_last().unwrap();
        assert_eq!(limit.terms, 1);
        assert!(limit.truncation.unwrap() <= 1.0 / g, "{name}");
        assert_eq!(sums.len(), 8);
        for pair in sums.windows(2) {
            assert!(pair[1].truncation <= pair[0].truncation, "{name}");
        }
    }
}

/// What is chosen for a tolerance keeps it, by fewer Gaussians than the sum of powers of the same error.
#[test]
fn chosen_gaussians_keep_the_tolerance() {
    let rows = rows();
    let mut count = 0;
    for name in [
        "g = 0.1", "g = 1", "g = 10", "g = 100", "g = 1000", "g = 1e4",
    ] {
        let of = |part| {
            rows.iter()
                .filter(move |row| row.part == part && row.name == name)
        };
        for (row, tolerance) in of("heights").zip([1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12]) {
            let error = row.truncation.unwrap();
            assert!(error <= tolerance, "{name} {tolerance}: {error}");
            let rivals =
                of("rough").filter(|sum| sum.terms > 1 && sum.truncation.unwrap() <= error);
            if let Some(least) = rivals.map(|sum| sum.terms).min() {
                assert!(
                    row.terms <= least,
                    "{name} {tolerance}: {} of {least}",
                    row.terms
                );
            }
            count += 1;
        }
    }
    assert_eq!(count, 6 * 7);
}
