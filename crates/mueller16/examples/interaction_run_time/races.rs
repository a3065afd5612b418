//! The races.

use std::error::Error;
use std::hint::black_box;

use csdm::film::{Layer, Stack};
use mueller16::{Autocorrelation, Channels, Geometry, IncidentCoherence, Tolerance};
use nalgebra::Matrix2;
use num_complex::Complex64;
use stokes::{GeneralizedStokes, Real};

use crate::matter::{self, LIGHT};
use crate::{Row, Table};

type Outcome = Result<(), Box<dyn Error>>;
type Work<'a> = Box<dyn FnMut() + 'a>;

fn transfer<'a>(c: &'a Channels, g: &'a Geometry, light: &'a IncidentCoherence) -> Work<'a> {
    Box::new(move || {
        let _ = black_box(black_box(c).transfer(black_box(g), black_box(light)));
    })
}

fn within<'a, T: Real>(
    c: &'a Channels,
    g: &'a Geometry,
    light: &'a IncidentCoherence,
    tolerance: Tolerance,
) -> Work<'a> {
    Box::new(move || {
        let _ = black_box(black_box(c).transfer_in::<T>(black_box(g), black_box(light), tolerance));
    })
}

fn amplitudes<'a>(c: &'a Channels, g: &'a Geometry, light: &'a GeneralizedStokes) -> Work<'a> {
    Box::new(move || {
        let _ = black_box(black_box(c).amplitudes(black_box(g), black_box(light)));
    })
}

fn row(name: &'static str, order: usize, terms: usize, channels: usize) -> Row {
    Row {
        name,
        order,
        terms,
        channels,
        number: "f64",
        truncation: None,
        rounding: None,
    }
}

fn one(step: usize) -> Result<Autocorrelation, Box<dyn Error>> {
    matter::family(&matter::root(step), 1)
}

/// Largest difference over a fan of directions, relative to the largest value.
fn error_of(
    found: impl Fn(&Geometry) -> Result<f64, Box<dyn Error>>,
    expected: impl Fn(&Geometry) -> Result<f64, Box<dyn Error>>,
) -> Result<f64, Box<dyn Error>> {
    let (mut error, mut most) = (0.0f64, 0.0f64);
    for step in 0..60 {
        let geometry = matter::geometry(5e-4 * f64::from(step))?;
        let (found, expected) = (found(&geometry)?, expected(&geometry)?);
        error = error.max((found - expected).abs());
        most = most.max(expected.abs());
    }
    Ok(error / most)
}

fn intensity(
    c: &Channels,
    light: &IncidentCoherence,
) -> impl Fn(&Geometry) -> Result<f64, Box<dyn Error>> {
    |g| Ok(c.transfer(g, light)?.total().element(0, 0))
}

/// Within 100 ns and 1.5 µs?
pub(crate) fn yardsticks(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    let (flat, modes) = (matter::light(0)?, matter::light(4)?);
    let light = matter::separate(&g, 4, 4)?;
    let [four, sixteen] = [4, 16].map(|count| one(0).map(|r| matter::shared(count, r)));
    let (four, sixteen) = (four?, sixteen?);
    let (apart, all_apart) = (matter::different(4)?, matter::different(16)?);
    let race = vec![
        (
            row("4 channels of one autocorrelation", 0, 1, 4),
            transfer(&four, &g, &flat),
        ),
        (
            row("4 channels of 4 autocorrelations", 0, 4, 4),
            transfer(&apart, &g, &flat),
        ),
        (
            row("16 channels of one autocorrelation", 4, 1, 16),
            transfer(&sixteen, &g, &modes),
        ),
        (
            row("16 channels of 16 autocorrelations", 4, 16, 16),
            transfer(&all_apart, &g, &modes),
        ),
        (
            row("the same with 4 series", 4, 16, 16),
            amplitudes(&all_apart, &g, &light),
        ),
    ];
    table.race("yardstick", race);
    Ok(())
}

/// Is the cost proportional to what is there?
pub(crate) fn channels(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    for order in [0, 4] {
        let light = matter::light(order)?;
        let names = ["16 of 16", "8 of 16", "4 of 16", "1 of 16"];
        let counts = [16, 8, 4, 1];
        let matters: Vec<Channels> = counts
            .into_iter()
            .map(matter::different)
            .collect::<Result<_, _>>()?;
        let race = names
            .into_iter()
            .zip(counts)
            .zip(&matters)
            .map(|((name, count), c)| (row(name, order, count, count), transfer(c, &g, &light)))
            .collect();
        table.race("channels", race);
    }
    Ok(())
}

/// What is gained by leaving out what is not there; the last of each race leaves out nothing.
pub(crate) fn skips(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    let (modes, long) = (matter::light(4)?, matter::light(8)?);
    let even = IncidentCoherence::new(LIGHT, &matter::series(8, false)?)?;
    let sixteen = matter::shared(16, one(0)?);
    let all_apart = matter::different(16)?;
    table.race(
        "skip",
        vec![
            (
                row("shared autocorrelation", 4, 1, 16),
                transfer(&sixteen, &g, &modes),
            ),
            (
                row("16 autocorrelations", 4, 16, 16),
                transfer(&all_apart, &g, &modes),
            ),
        ],
    );
    table.race(
        "skip",
        vec![
            (
                row("modes above 4 absent", 4, 1, 16),
                transfer(&sixteen, &g, &modes),
            ),
            (
                row("odd modes absent", 8, 1, 16),
                transfer(&sixteen, &g, &even),
            ),
            (row("modes to 8", 8, 1, 16), transfer(&sixteen, &g, &long)),
        ],
    );
    let lights = [1, 4].map(|count| matter::separate(&g, 4, count));
    let [unpolarized, full] = lights;
    let (unpolarized, full) = (unpolarized?, full?);
    table.race(
        "skip",
        vec![
            (
                row("three components absent", 4, 1, 16),
                amplitudes(&sixteen, &g, &unpolarized),
            ),
            (
                row("four components", 4, 1, 16),
                amplitudes(&sixteen, &g, &full),
            ),
        ],
    );
    let isotropic = IncidentCoherence::new(Matrix2::identity() * 8e4, &matter::series(4, true)?)?;
    let round = matter::shared(4, matter::family(&(Matrix2::identity() * 1e-5), 64)?);
    let oblique = matter::shared(4, matter::family(&matter::root(0), 64)?);
    let single = Row {
        number: "f32",
        ..row("64 Gaussians in f32", 4, 64, 4)
    };
    table.race(
        "skip",
        vec![
            (
                row("64 Gaussians isotropic", 4, 64, 4),
                transfer(&round, &g, &isotropic),
            ),
            (
                single,
                within::<f32>(&oblique, &g, &modes, Tolerance::ROUNDING),
            ),
            (
                row("64 Gaussians", 4, 64, 4),
                transfer(&oblique, &g, &modes),
            ),
        ],
    );
    Ok(())
}

/// A Gaussian source over a shape of twice its variance on one rough Gaussian: time and error over the order.
pub(crate) fn orders(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    let exact = matter::gaussian_source(None)?;
    for (name, single, r) in [
        (
            "series; g = 10",
            "series in f32; g = 10",
            matter::rough(10.0, 1e-16)?,
        ),
        (
            "series; g = 1e4",
            "series in f32; g = 1e4",
            matter::very_rough(1e4)?,
        ),
    ] {
        let matter = matter::shared(4, r.clone());
        for order in [0, 2, 4, 6, 8, 12, 16, 24, 32] {
            let light = matter::gaussian_source(Some(order))?;
            let truth = intensity(&matter, &exact);
            let error = error_of(intensity(&matter, &light), &truth)?;
            let in_single = |g: &Geometry| {
                let found = matter.transfer_in::<f32>(g, &light, Tolerance::ROUNDING)?;
                Ok(found.total().element(0, 0))
            };
            let rounding = error_of(in_single, intensity(&matter, &light))?;
            let terms = r.term_count();
            let f64_row = Row {
                truncation: Some(error),
                ..row(name, order, terms, 4)
            };
            let f32_row = Row {
                number: "f32",
                truncation: Some(error),
                rounding: Some(rounding),
                ..row(single, order, terms, 4)
            };
            table.race(
                "order",
                vec![
                    (
                        f32_row,
                        within::<f32>(&matter, &g, &light, Tolerance::ROUNDING),
                    ),
                    (f64_row, transfer(&matter, &g, &light)),
                ],
            );
        }
    }
    Ok(())
}

/// A rough surface by fewer and fewer Gaussians, and by the one of its limit.
pub(crate) fn roughness(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    let light = matter::light(0)?;
    for (name, roughness) in [
        ("g = 0.1", 0.1),
        ("g = 1", 1.0),
        ("g = 10", 10.0),
        ("g = 100", 100.0),
        ("g = 1000", 1e3),
        ("g = 1e4", 1e4),
    ] {
        let truth = matter::shared(4, matter::rough(roughness, 1e-18)?);
        let cuts = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-12, 1e-16];
        let sums = cuts
            .into_iter()
            .map(|least| matter::rough(roughness, least));
        let limit = matter::very_rough(roughness);
        for r in sums.chain([limit]) {
            let r = r?;
            let terms = r.term_count();
            let matter = matter::shared(4, r);
            let error = error_of(intensity(&matter, &light), intensity(&truth, &light))?;
            let entry = Row {
                truncation: Some(error),
                ..row(name, 0, terms, 4)
            };
            table.race("rough", vec![(entry, transfer(&matter, &g, &light))]);
        }
    }
    Ok(())
}

/// A rough surface to a tolerance: the transfer by the Gaussians that are chosen for it, and the choosing with it.
pub(crate) fn heights(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    let light = matter::light(0)?;
    for (name, with_choice, roughness) in [
        ("g = 0.1", "g = 0.1 with the choice", 0.1),
        ("g = 1", "g = 1 with the choice", 1.0),
        ("g = 10", "g = 10 with the choice", 10.0),
        ("g = 100", "g = 100 with the choice", 100.0),
        ("g = 1000", "g = 1000 with the choice", 1e3),
        ("g = 1e4", "g = 1e4 with the choice", 1e4),
    ] {
        let truth = matter::shared(4, matter::rough(roughness, 1e-18)?);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12] {
            let tolerance = Tolerance::relative(tolerance)?;
            let r = matter::heights(roughness, tolerance)?;
            let terms = r.term_count();
            let matter = matter::shared(4, r);
            let error = error_of(intensity(&matter, &light), intensity(&truth, &light))?;
            let entry = Row {
                truncation: Some(error),
                ..row(name, 0, terms, 4)
            };
            let whole: Work<'_> = Box::new(|| {
                if let Ok(r) = matter::heights(black_box(roughness), tolerance) {
                    let _ = black_box(matter::shared(4, r).transfer(black_box(&g), &light));
                }
            });
            table.race(
                "heights",
                vec![
                    (row(with_choice, 0, terms, 4), whole),
                    (entry, transfer(&matter, &g, &light)),
                ],
            );
        }
    }
    Ok(())
}

/// A grating of 41 orders, with a tolerance that leaves out those far from the direction.
pub(crate) fn grating(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    for order in [0, 4] {
        let light = matter::light(order)?;
        let r = matter::grating(41)?;
        let terms = r.term_count();
        let matter = matter::shared(8, r);
        let mut race = vec![];
        for (name, tolerance) in [
            ("orders within 1e-2", 1e-2),
            ("orders within 1e-4", 1e-4),
            ("orders within 1e-8", 1e-8),
        ] {
            let tolerance = Tolerance::relative(tolerance)?;
            let found = |g: &Geometry| {
                let found = matter.transfer_in::<f64>(g, &light, tolerance)?;
                Ok(found.total().element(0, 0))
            };
            let entry = Row {
                truncation: Some(error_of(found, intensity(&matter, &light))?),
                ..row(name, order, terms, 8)
            };
            race.push((entry, within::<f64>(&matter, &g, &light, tolerance)));
        }
        race.push((
            row("all orders", order, terms, 8),
            transfer(&matter, &g, &light),
        ));
        table.race("grating", race);
    }
    Ok(())
}

/// Rough layers: the Mueller matrix of the stack at the half vector, and the transfer with it.
pub(crate) fn layers(table: &mut Table) -> Outcome {
    let g = matter::geometry(1e-3)?;
    let light = matter::light(0)?;
    for (name, alone, count) in [
        ("1 layer with its matrix", "1 layer: matrix alone", 1),
        ("8 layers with their matrix", "8 layers: matrix alone", 8),
    ] {
        let layers = (0..count)
            .map(|i| Layer {
                index: Complex64::new(if i % 2 == 0 { 2.3 } else { 1.38 }, 0.0),
                thickness: 1e-7,
            })
            .collect();
        let stack = Stack::new(1.0, layers, Complex64::new(1.5, 0.0))?;
        let r = one(0)?;
        let cosine = |g: &Geometry| g.half_vector().map_or(1.0, |h| h.dot(&g.to_source()));
        let matrix = |g: &Geometry| {
            stack
                .amplitudes(cosine(g).min(1.0), g.wavelength())
                .reflection_mueller()
        };
        let fixed = Channels::new(&matrix(&g), r.clone());
        let whole: Work<'_> = Box::new(|| {
            let channels = Channels::new(&matrix(black_box(&g)), r.clone());
            let _ = black_box(channels.transfer(&g, black_box(&light)));
        });
        let matrix_alone: Work<'_> = Box::new(|| {
            black_box(matrix(black_box(&g)));
        });
        table.race(
            "layers",
            vec![
                (row(name, 0, 1, fixed.set().len()), whole),
                (row(alone, 0, 1, fixed.set().len()), matrix_alone),
                (
                    row("transfer alone", 0, 1, fixed.set().len()),
                    transfer(&fixed, &g, &light),
                ),
            ],
        );
    }
    Ok(())
}
