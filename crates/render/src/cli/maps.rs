//! `brewster maps`: pictures of a Stokes image.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{Failure, Outcome};
use crate::analyzer::{self, Destination, Incident};
use crate::maps::{self, ColourChoice, HandednessColours, MapOptions, MapReport, write_all};
use crate::output::{self, ImageError, WriteOptions};

/// Command line of `brewster maps`.
#[derive(clap::Args, Debug)]
pub struct Args {
    /// Stokes image: EXR (ours, Mitsuba's or spectral), .npy or .npz
    pub image: PathBuf,
    /// Folder for the pictures, created where missing
    #[arg(short, long, default_value = ".", value_name = "DIR")]
    pub output: PathBuf,
    /// Maps to draw, separated by commas; all where absent: s0, s1, s2, s3, dop, dolp, docp, aolp, aolp-dolp, ellipticity, type, ellipses, coherence, coherence-degree, coherence-ellipses
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub maps: Vec<String>,
    /// Images behind analyzers, with pictures; other maps only where named: linear:ANGLE, rcp, lcp, camera, mosaic, MUELLER.json, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    pub analyzer: Vec<String>,
    /// Mask pixels darker than this times the mean S0
    #[arg(
        long,
        default_value_t = 0.01,
        allow_negative_numbers = true,
        value_name = "X"
    )]
    pub threshold: f64,
    /// Colours of right- and left-handed light
    #[arg(long, value_enum, default_value_t, value_name = "WHOSE")]
    pub handedness_colours: HandednessColours,
    /// Distance of the ellipses in image pixels
    #[arg(long, value_name = "PX")]
    pub ellipse_spacing: Option<usize>,
    /// What of a coloured image to draw: luminance, r, g, b, or the number of a band
    #[arg(long, default_value = "luminance", value_name = "WHICH")]
    pub colour: ColourChoice,
    /// Factor from S0 to display white; follows the image where absent
    #[arg(long, allow_negative_numbers = true, value_name = "X")]
    pub exposure: Option<f64>,
    /// Let degrees span 0 to 1, and S1, S2, S3, DoCP -1 to 1, whatever the image needs
    #[arg(long)]
    pub full_range: bool,
    /// Write each map's numbers too, as .npy (angles in radians, NaN where masked)
    #[arg(long)]
    pub data: bool,
    /// Print the side-car JSON instead of the list of files; one after the other where there are two
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let usage = |e: ImageError| Failure::Usage(e.to_string());
    maps::check_names(&args.maps).map_err(usage)?;
    let analyzers = analyzer::parse(&args.analyzer).map_err(usage)?;
    for notice in &analyzers.notices {
        eprintln!("notice: {notice}");
    }
    let image = output::read(&args.image).map_err(usage)?;
    let options = MapOptions {
        maps: args.maps.clone(),
        threshold: args.threshold,
        handedness_colours: args.handedness_colours,
        ellipse_spacing: args.ellipse_spacing,
        colour: args.colour,
        exposure: args.exposure,
        data: args.data,
        full_range: args.full_range,
    };
    let stem = args.image.file_stem().unwrap_or_default().to_string_lossy();
    if !analyzers.list.is_empty() {
        let destination = Destination {
            folder: &args.output,
            stem: &stem,
            npy: output::is_array(&args.image),
            write: WriteOptions::default(),
            pictures: &options,
            draw: true,
        };
        let report = Incident::new(&image, None)
            .and_then(|light| analyzer::write_all(&light, &analyzers, &destination))
            .map_err(failure)?;
        tell(args, &report, &report.files)?;
        if options.maps.is_empty() {
            return Ok(ExitCode::SUCCESS);
        }
    }
    let report = write_all(&image, &options, &args.output, &stem).map_err(failure)?;
    tell(args, &report, &report.files)?;
    if !args.json {
        warn(&report);
    }
    Ok(ExitCode::SUCCESS)
}

fn failure(error: ImageError) -> Failure {
    match error {
        ImageError::Request(_) => Failure::Usage(error.to_string()),
        _ => Failure::Work(error.to_string()),
    }
}

/// Prints a report as JSON, or the files that it tells of.
fn tell(args: &Args, report: &impl serde::Serialize, files: &[PathBuf]) -> Result<(), Failure> {
    if args.json {
        let json = serde_json::to_string_pretty(report);
        let json = json.map_err(|e| Failure::Work(e.to_string()))?;
        super::say(&format!("{json}\n"));
    } else {
        for path in files {
            super::say(&format!("{}\n", path.display()));
        }
    }
    Ok(())
}

fn warn(report: &MapReport) {
    let statistics = &report.statistics;
    if statistics.dop_above_one_share > 0.0 {
        eprintln!(
            "brewster: {:.3} % of the pixels have a degree of polarization above 1 (greatest {:.3}): noise, or not a Stokes image",
            100.0 * statistics.dop_above_one_share,
            statistics.greatest_dop
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::TABLE;
    use clap::CommandFactory;

    #[derive(clap::Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    #[test]
    fn the_help_names_every_map() {
        let command = Command::command();
        let help = command
            .get_arguments()
            .find(|a| a.get_id() == "maps")
            .and_then(|a| a.get_help())
            .unwrap()
            .to_string();
        let names: Vec<&str> = TABLE.iter().map(|map| map.name).collect();
        assert!(help.ends_with(&names.join(", ")), "{help}");
    }
}
