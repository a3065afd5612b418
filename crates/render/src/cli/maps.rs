//! `brewster maps`: pictures of a Stokes image.

use std::path::PathBuf;
use std::process::ExitCode;

use super::{Failure, Outcome};
use crate::maps::{ColourChoice, HandednessColours, MapOptions, MapReport, write_all};
use crate::output::{self, ImageError};

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
    /// Print the side-car JSON instead of the list of files
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let image = output::read(&args.image).map_err(|e| Failure::Usage(e.to_string()))?;
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
    let report = write_all(&image, &options, &args.output, &stem).map_err(|e| match e {
        ImageError::Request(_) => Failure::Usage(e.to_string()),
        _ => Failure::Work(e.to_string()),
    })?;
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&report).map_err(|e| Failure::Work(e.to_string()))?
        );
    } else {
        print(&report);
    }
    Ok(ExitCode::SUCCESS)
}

fn print(report: &MapReport) {
    for path in &report.files {
        println!("{}", path.display());
    }
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
