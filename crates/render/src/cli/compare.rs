//! `brewster compare`: a table of differences, and an exit status for scripts.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::{Failure, Outcome};
use crate::compare::{Field, Row, Settings, compare, mean_of_seeds};
use crate::image::StokesImage;
use crate::output;

/// Command line of `brewster compare`.
///
/// Exit status: 0 passed, or no threshold given; 1 a threshold exceeded; 2 unusable input.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Image under test: EXR (ours or Mitsuba's), .npy or .npz
    pub test: PathBuf,
    /// Reference image: the same kinds; variances in it are used
    pub reference: PathBuf,
    /// Further renders of the test scene with other seeds: mean and standard error are taken over all of them
    #[arg(long, num_args = 1.., value_name = "FILE")]
    pub test_seeds: Vec<PathBuf>,
    /// Image whose S0..S3 are the standard errors of the test image (an .npz may hold 'stderr' instead)
    #[arg(long, value_name = "FILE")]
    pub test_stderr: Option<PathBuf>,
    /// Side of a block in pixels
    #[arg(long, default_value_t = 8, value_name = "N")]
    pub block: usize,
    /// Relative round-off added to the standard errors
    #[arg(
        long,
        default_value_t = 1e-6,
        allow_negative_numbers = true,
        value_name = "X"
    )]
    pub floor: f64,
    /// Give rmse, excess, bias and abs limits in units of the mean reference S0
    #[arg(long)]
    pub relative: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// Limit on the root mean square difference: one number, or four for S0,S1,S2,S3
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_rmse: Option<Limits>,
    /// Limit on the difference that noise does not explain
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_excess: Option<Limits>,
    /// Limit on the mean difference
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_bias: Option<Limits>,
    /// Limit on the mean difference in its own standard errors
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_bias_t: Option<Limits>,
    /// Limit on the share of numbers more than 4 standard errors off
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_z_frac: Option<Limits>,
    /// Limit on the share of blocks more than 5 standard errors off
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_block_frac: Option<Limits>,
    /// Limit on the greatest absolute difference
    #[arg(long, value_parser = limits, value_name = "X[,X,X,X]")]
    pub max_abs: Option<Limits>,
}

/// One limit per Stokes component.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits(Box<[f64; 4]>);

fn limits(text: &str) -> Result<Limits, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|n| n.trim().parse().ok())
        .filter(|n: &f64| !n.is_nan())
        .collect();
    match numbers[..] {
        _ if numbers.len() != text.split(',').count() => {
            Err("expected one number or four separated by commas".to_owned())
        }
        [x] => Ok(Limits(Box::new([x; 4]))),
        [a, b, c, d] => Ok(Limits(Box::new([a, b, c, d]))),
        _ => Err("expected one number or four separated by commas".to_owned()),
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let reference = read(&args.reference)?;
    let (rows, scale) = rows(args, &reference)?;
    let fails = failures(args, &rows, if args.relative { scale } else { 1.0 })?;
    if args.json {
        let report = serde_json::json!({"meta": reference.metadata, "mean_S0": scale, "rows": rows, "failures": fails});
        super::say(&format!("{report}\n"));
    } else {
        super::say(&table(&reference, &rows, scale));
        for fail in &fails {
            super::say(&format!("FAIL {fail}\n"));
        }
        let limited = limited(args).iter().any(|(_, limits)| limits.is_some());
        super::say(&format!(
            "{}\n",
            if !fails.is_empty() {
                "FAILED"
            } else if limited {
                "PASSED"
            } else {
                "report only (no thresholds given)"
            }
        ));
    }
    Ok(if fails.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

fn read(path: &Path) -> Result<StokesImage, Failure> {
    output::read(path).map_err(|e| Failure::Usage(e.to_string()))
}

fn rows(args: &Args, reference: &StokesImage) -> Result<(Vec<Row>, f64), Failure> {
    let named = |path: &Path| path.display().to_string();
    let image = read(&args.test)?;
    let mut r = Field::stokes(reference);
    let mut r_error = Field::standard_errors(reference);
    if image.components < r.components {
        eprintln!(
            "brewster: {} has S0 only; S0 alone is compared",
            named(&args.test)
        );
        r = r.first_component();
        r_error = r_error.map(|e| e.first_component());
    }
    let matched = |field: Field, what: &str| field.matched(&r, what).map_err(Failure::Usage);
    let mut test = matched(Field::stokes(&image), &named(&args.test))?;
    let mut test_error = match Field::standard_errors(&image) {
        Some(e) => Some(matched(
            e,
            &format!("the variance of {}", named(&args.test)),
        )?),
        None => None,
    };
    if !args.test_seeds.is_empty() {
        let mut renders = vec![test];
        for path in &args.test_seeds {
            renders.push(matched(Field::stokes(&read(path)?), &named(path))?);
        }
        let (mean, error) = mean_of_seeds(&renders);
        (test, test_error) = (mean, Some(error));
    }
    if let Some(path) = &args.test_stderr {
        test_error = Some(matched(
            Field::stokes(&standard_errors(path)?),
            &named(path),
        )?);
    }
    let settings = Settings {
        block: args.block,
        floor: args.floor,
    };
    compare(&test, &r, test_error.as_ref(), r_error.as_ref(), &settings).map_err(Failure::Usage)
}

fn standard_errors(path: &Path) -> Result<StokesImage, Failure> {
    if path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("npz"))
    {
        return output::npy::read_npz(path, "stderr").map_err(|e| Failure::Usage(e.to_string()));
    }
    read(path)
}

fn limited(args: &Args) -> [(&'static str, Option<&Limits>); 7] {
    [
        ("rmse", args.max_rmse.as_ref()),
        ("excess", args.max_excess.as_ref()),
        ("bias", args.max_bias.as_ref()),
        ("bias-t", args.max_bias_t.as_ref()),
        ("z-frac", args.max_z_frac.as_ref()),
        ("block-frac", args.max_block_frac.as_ref()),
        ("abs", args.max_abs.as_ref()),
    ]
}

fn failures(args: &Args, rows: &[Row], unit: f64) -> Result<Vec<String>, Failure> {
    let mut out = Vec::new();
    for (k, row) in rows.iter().enumerate() {
        for (name, limits) in limited(args) {
            let Some(Limits(limits)) = limits else {
                continue;
            };
            let value = match name {
                "rmse" => Some(row.rmse / unit),
                "excess" => row.excess_rmse.map(|e| e / unit),
                "bias" => Some(row.mean.abs() / unit),
                "bias-t" => Some(row.mean_t.abs()),
                "z-frac" => row.z4_frac,
                "block-frac" => Some(row.block5_frac),
                _ => Some(row.max_abs / unit),
            };
            let value = value.ok_or_else(|| {
                Failure::Usage(format!(
                    "--max-{name} needs standard errors of the test image; give an image with variances, --test-seeds or --test-stderr"
                ))
            })?;
            if value > limits[k] {
                out.push(format!(
                    "{} {name} {} > {}",
                    row.component,
                    general(value, 4),
                    general(limits[k], 4)
                ));
            }
        }
    }
    Ok(out)
}

fn table(reference: &StokesImage, rows: &[Row], scale: f64) -> String {
    let known = |key: &str, otherwise: &str| {
        reference
            .metadata
            .get(key)
            .cloned()
            .unwrap_or_else(|| otherwise.to_owned())
    };
    let mut out = format!(
        "reference {} {} {} spp; mean S0 = {}\n      rmse       excess     mean        (t)      z>4       z rms   block>5   max\n",
        known("scene", "?"),
        known("variant", ""),
        known("spp", "?"),
        general(scale, 5)
    );
    let maybe = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| general(v, 3));
    for row in rows {
        out += &format!(
            "{} {:>10} {:>10} {:>11} {:>8.2} {:>9} {:>8} {:>9.4} {:>9}\n",
            row.component,
            general(row.rmse, 4),
            maybe(row.excess_rmse),
            general(row.mean, 4),
            row.mean_t,
            maybe(row.z4_frac),
            maybe(row.z_rms),
            row.block5_frac,
            general(row.max_abs, 4)
        );
    }
    out
}

/// A number with `digits` significant digits, plain or with an exponent, as C's `%g` prints it.
fn general(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return value.to_string().to_lowercase();
    }
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific
        .split_once('e')
        .expect("the format has an exponent");
    let exponent: i32 = exponent.parse().expect("the exponent is a number");
    let trimmed = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text.to_owned()
        }
    };
    if (-4..digits as i32).contains(&exponent) {
        return trimmed(&format!(
            "{value:.*}",
            (digits as i32 - 1 - exponent).max(0) as usize
        ));
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", trimmed(mantissa), exponent.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_print_as_in_c() {
        let cases = [
            (0.0, 4, "0"),
            (0.002639, 4, "0.002639"),
            (1e-6, 4, "1e-06"),
            (0.00012345, 3, "0.000123"),
            (0.000012345, 4, "1.234e-05"),
            (123456.0, 4, "1.235e+05"),
            (9999.6, 4, "1e+04"),
            (1.5, 5, "1.5"),
            (-0.25, 4, "-0.25"),
            (1000.0, 4, "1000"),
            (f64::INFINITY, 4, "inf"),
            (f64::NAN, 4, "nan"),
        ];
        for (value, digits, expected) in cases {
            assert_eq!(general(value, digits), expected);
        }
    }

    #[test]
    fn limits_are_one_number_or_four() {
        assert_eq!(limits("0.5"), Ok(Limits(Box::new([0.5; 4]))));
        assert_eq!(
            limits("1,2,3,4e-1"),
            Ok(Limits(Box::new([1.0, 2.0, 3.0, 0.4])))
        );
        for bad in ["", "1,2", "1,x,3,4", "nan", "1,2,3,4,5"] {
            assert!(limits(bad).is_err(), "{bad}");
        }
    }
}
