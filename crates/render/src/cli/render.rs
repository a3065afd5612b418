//! `brewster render`: what the user typed, turned into a job, run and written.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use cpu_time::ProcessTime;

use super::progress::{progress_bar, show, stop_on_interrupt};
use super::values::{Crop, Define, ErrorTargets, Separation, Size, parse_duration, parse_patch};
use super::wavelengths::Wavelengths;
use super::{Failure, Outcome};
use crate::analyzer::{self, Destination, Incident};
use crate::engine::{self, Job, Limits, Rendering, Targets};
use crate::film::SpectralMode;
use crate::image::{BLOCKS, Colour, SAMPLES, StokesImage};
use crate::maps::{self, MapOptions};
use crate::output::{self, ImageError, WriteOptions};
use crate::plan::{Plan, Request};
use crate::sampler::Generator;
use crate::scene::{self, Overrides};

const GIB: u64 = 1 << 30;
/// Samples a pixel where nobody limits them.
const MOST_SAMPLES: u64 = 1 << 40;
/// Most memory that the film may take.
const MOST_MEMORY: u64 = 16 * GIB;

/// Command line of `brewster render`.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Environment:\n  BREWSTER_SIMD=avx2|portable  Fewer of the processor's vector instructions; the image is the same"
)]
pub struct Args {
    /// Scene file (Mitsuba 3 XML)
    scene: PathBuf,
    /// Image to write: .exr or .npy [default: the scene's name with .exr, in the current folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Samples a pixel [default: the scene's; with --target-error as many as it takes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_SAMPLES))]
    spp: Option<u64>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Size of the film instead of the scene's
    #[arg(long, value_name = "WxH")]
    size: Option<Size>,
    /// Render only this window of the film
    #[arg(long, value_name = "X,Y,W,H")]
    crop: Option<Crop>,
    #[command(flatten)]
    wavelengths: Wavelengths,
    /// S0 alone, by scalar transport
    #[arg(long)]
    unpolarized: bool,
    /// Half-width of emitter patches, in widths of the lobe that sees them; 0: single points [default: the scene's, or 0.5]
    #[arg(long, value_name = "R", value_parser = parse_patch)]
    patch: Option<f32>,
    /// Also the coherence of each pixel's light where it first meets matter that is not specular, or on a bare sensor
    /// plane: ellipse, and degree at this separation toward image right, or right and up
    #[arg(
        long,
        value_name = "10um[,5um]",
        allow_hyphen_values = true,
        conflicts_with = "mitsuba_channels"
    )]
    coherence: Option<Separation>,
    /// Generator of the random numbers
    #[arg(long, value_enum, default_value_t)]
    sampler: Generator,
    /// Stop after this time with the samples taken so far
    #[arg(long, value_name = "60s", value_parser = parse_duration)]
    time: Option<Duration>,
    /// Stop at this error, √(mean variance of the mean)/mean S0, of every component or of some; adaptive
    #[arg(long, value_name = "0.01|S0=0.01,…")]
    target_error: Option<ErrorTargets>,
    /// Give samples to the pixels that are noisy: --spp is what a pixel gets on the mean
    #[arg(long)]
    adaptive: bool,
    /// Threads [default: one a core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Fill $NAME in the scene file
    #[arg(short = 'D', value_name = "NAME=VALUE")]
    define: Vec<Define>,
    /// Pictures to make beside the image: `all`, or names from `brewster maps --help`, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "LIST")]
    maps: Vec<String>,
    /// Images behind analyzers beside the image: linear:ANGLE, rcp, lcp, camera, mosaic, MUELLER.json, separated by commas
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "LIST",
        conflicts_with = "unpolarized"
    )]
    analyzer: Vec<String>,
    /// Write exactly the channels that Mitsuba writes
    #[arg(long)]
    mitsuba_channels: bool,
    /// Say what the scene does not need and is skipped, what is kept, and because of whom
    #[arg(long)]
    explain: bool,
    /// Follow what the scene does not need too; the image is the same within rounding
    #[arg(long)]
    no_skip: bool,
    /// No progress bar and no notices
    #[arg(short, long)]
    quiet: bool,
    /// One line of JSON with times and rates on standard output
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let (start, cpu_start) = (Instant::now(), ProcessTime::now());
    let output = output_path(args)?;
    map_options(args)?;
    let analyzers = analyzer::parse(&args.analyzer).map_err(refusal)?;
    let threads = args.threads.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    );
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| Failure::Work(format!("{threads} threads cannot be started: {e}")))?;
    let (job, notices) = pool.install(|| load(args))?;
    if args.explain {
        for decision in job.plan.decisions() {
            eprintln!("{:<8} {decision}", decision.verdict());
        }
    }
    if !args.quiet {
        for notice in analyzers.notices.iter().chain(&notices) {
            eprintln!("notice: {notice}");
        }
    }
    let bar = progress_bar(args.quiet, Some(job.samples).filter(|n| *n < MOST_SAMPLES));
    let stop = stop_on_interrupt()?;
    let limits = Limits {
        time: args.time,
        error: args.target_error.map(|targets| Targets(targets.targets)),
    };
    let rendering =
        pool.install(|| engine::render(&job, limits, &stop, |progress| show(&bar, progress)));
    bar.finish_and_clear();

    let image = to_image(args, &job, &rendering);
    let write = WriteOptions {
        mitsuba_channels: args.mitsuba_channels,
    };
    output::write(&output, &image, &write).map_err(failure)?;
    if !args.quiet {
        tell(&output, &rendering, start.elapsed());
    }
    let pictures = map_options(args)?;
    let folder = output.parent().unwrap_or(Path::new(""));
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    if let Some(options) = &pictures {
        maps::write_all(&image, options, folder, &stem).map_err(failure)?;
    }
    if !analyzers.list.is_empty() {
        let destination = Destination {
            folder,
            stem: &stem,
            npy: output::is_array(&output),
            write,
            draw: pictures.is_some(),
            pictures: &pictures.unwrap_or_default(),
        };
        Incident::new(&image, Some(&rendering))
            .and_then(|light| analyzer::write_all(&light, &analyzers, &destination))
            .map_err(failure)?;
    }
    if args.json {
        print_json(&rendering, threads, start.elapsed(), cpu_start.elapsed());
    }
    Ok(ExitCode::SUCCESS)
}

/// The pictures to make, if any; a misspelt name is refused before any work is done.
fn map_options(args: &Args) -> Result<Option<MapOptions>, Failure> {
    if args.maps.is_empty() {
        return Ok(None);
    }
    let maps = if args.maps == ["all"] {
        Vec::new()
    } else {
        args.maps.clone()
    };
    maps::check_names(&maps).map_err(failure)?;
    if args.coherence.is_none()
        && let Some(name) = maps.iter().find(|name| maps::needs_coherence(name))
    {
        return Err(Failure::Usage(format!(
            "--maps: '{name}' needs coherence; ask for it by --coherence 10um"
        )));
    }
    Ok(Some(MapOptions {
        maps,
        ..MapOptions::default()
    }))
}

/// What is wrong with the command line or with a file that it names.
fn refusal(error: ImageError) -> Failure {
    Failure::Usage(error.to_string())
}

fn failure(error: ImageError) -> Failure {
    match error {
        ImageError::Request(_) => Failure::Usage(error.to_string()),
        _ => Failure::Work(error.to_string()),
    }
}

/// Where the image goes. Endings that cannot be written are refused, and the folder is made, before any work is done.
fn output_path(args: &Args) -> Result<PathBuf, Failure> {
    let Some(output) = &args.output else {
        let stem = args.scene.file_stem().unwrap_or(args.scene.as_os_str());
        return Ok(Path::new(stem).with_extension("exr"));
    };
    let known = output
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("exr") || e.eq_ignore_ascii_case("npy"));
    if !known {
        return Err(Failure::Usage(format!(
            "{}: unknown kind of image, expected a name in .exr or .npy",
            output.display()
        )));
    }
    if let Some(folder) = output.parent() {
        std::fs::create_dir_all(folder).map_err(|e| {
            Failure::Work(format!(
                "{}: the folder for the image cannot be made: {e}",
                folder.display()
            ))
        })?;
    }
    Ok(output.clone())
}

/// Reads the scene and joins it with the command line; also what the user should know about the file.
fn load(args: &Args) -> Result<(Job, Vec<String>), Failure> {
    let wrong = |e: scene::SceneError| Failure::Usage(e.to_string());
    let defines: Vec<(String, String)> = args
        .define
        .iter()
        .map(|d| (d.name.clone(), d.value.clone()))
        .collect();
    let document = scene::read(&args.scene, &defines).map_err(wrong)?;
    let overrides = Overrides {
        size: args.size.map(|s| s.0),
        crop: args.crop.map(|c| c.0),
    };
    let mut built = scene::build(&document, overrides).map_err(wrong)?;
    built.film.products = !args.analyzer.is_empty();
    let film = &built.film;
    let fits = (0..2).all(|axis| {
        film.crop_offset[axis]
            .checked_add(film.crop_size[axis])
            .is_some_and(|end| end <= film.size[axis])
    });
    if !fits {
        return Err(Failure::Usage(format!(
            "--crop: {},{},{},{} reaches beyond the film, expected a window within {}x{}",
            film.crop_offset[0],
            film.crop_offset[1],
            film.crop_size[0],
            film.crop_size[1],
            film.size[0],
            film.size[1]
        )));
    }
    let mode = args.wavelengths.mode();
    built.scene.check_wavelengths(mode.range()).map_err(wrong)?;
    let mut notices = document.notices();
    notices.extend(built.scene.doubts(mode.range()));
    let adaptive = args.adaptive || args.target_error.is_some();
    let bytes = film.bytes(mode.colours(), args.coherence.is_some(), adaptive);
    if bytes > MOST_MEMORY {
        return Err(Failure::Usage(format!(
            "{}: a film of {} x {} pixels with {} colours takes {:.1} GiB, expected at most {:.0}; --size or --crop make it smaller",
            args.scene.display(),
            film.crop_size[0],
            film.crop_size[1],
            mode.colours(),
            bytes as f64 / GIB as f64,
            MOST_MEMORY as f64 / GIB as f64
        )));
    }
    built.paths.patch = args.patch.unwrap_or(built.paths.patch);
    let plan = Plan::of(
        &built,
        &Request {
            mode: &mode,
            polarized: !args.unpolarized,
            coherence: args.coherence.is_some(),
            skip: !args.no_skip,
        },
    );
    if args.no_skip {
        built.scene.follow_everything();
    }
    let samples = match (args.spp, args.target_error) {
        (Some(samples), _) => samples,
        (None, Some(_)) => MOST_SAMPLES,
        (None, None) => built.samples,
    };
    if args.unpolarized
        && let Some(component) = args.target_error.and_then(|targets| targets.beyond_s0())
    {
        return Err(Failure::Usage(format!(
            "--target-error: S{component} is not rendered with --unpolarized; expected S0 alone, or no --unpolarized"
        )));
    }
    let block = if adaptive {
        args.sampler.largest_block()
    } else {
        args.sampler.block(samples, args.time.is_some())
    };
    let job = Job {
        polarized: !args.unpolarized,
        plan,
        coherence: args.coherence.map(|separation| separation.0),
        samples,
        adaptive,
        block,
        seed: args.seed,
        ..Job::new(built, mode)
    };
    Ok((job, notices))
}

fn to_image(args: &Args, job: &Job, rendering: &Rendering) -> StokesImage {
    let [width, height] = job.film.crop_size.map(|n| n as usize);
    let colour = match &job.mode {
        SpectralMode::Single(wavelength) => Colour::Mono {
            wavelength_nm: Some(*wavelength),
        },
        SpectralMode::Bands { .. } => Colour::Bands {
            wavelengths_nm: job.mode.band_centres(),
        },
        SpectralMode::Rgb => Colour::Rgb,
    };
    let mut image = StokesImage::new(width, height, rendering.components(), colour);
    let (means, variances) = rendering.image();
    image.stokes = means;
    // one block has no variance
    image.variance = (rendering.fewest_blocks() > 1).then_some(variances);
    image.samples = rendering.adaptive.then(|| rendering.samples_of_pixels());
    image.coherence = rendering.coherence();
    image.metadata = metadata(args, job, rendering);
    image
}

fn metadata(
    args: &Args,
    job: &Job,
    rendering: &Rendering,
) -> std::collections::BTreeMap<String, String> {
    let wavelengths = match &job.mode {
        SpectralMode::Single(wavelength) => format!("{wavelength} nm"),
        SpectralMode::Bands { from, to, count } => {
            format!("{count} equal bands from {from} to {to} nm, mean over each")
        }
        SpectralMode::Rgb => "linear sRGB from 360 to 830 nm, CIE 1931".to_owned(),
    };
    let since_epoch = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |d| d.as_secs());
    let coherence = job.coherence.map(|[x, y]| {
        (
            maps::SEPARATION,
            format!("{x:e} m toward image right, {y:e} m toward image up"),
        )
    });
    [
        ("scene", args.scene.display().to_string()),
        ("seed", job.seed.to_string()),
        (SAMPLES, format!("{:.0}", rendering.mean_samples())),
        (BLOCKS, rendering.fewest_blocks().to_string()),
        ("wavelengths", wavelengths),
        ("sensor", job.camera.describe().to_owned()),
        ("frame", job.camera.frame().to_owned()),
        (
            "handedness",
            "S3 > 0: clockwise for an observer who faces the source (right-handed)".to_owned(),
        ),
        ("version", format!("brewster {}", env!("CARGO_PKG_VERSION"))),
        ("time", format!("{since_epoch} s since 1970-01-01 UTC")),
        (
            "renderSeconds",
            format!("{:.3}", rendering.wall.as_secs_f64()),
        ),
    ]
    .into_iter()
    .chain(coherence)
    .map(|(key, value)| (key.to_owned(), value))
    .collect()
}

fn tell(output: &Path, rendering: &Rendering, elapsed: Duration) {
    let stopped = if rendering.interrupted {
        " (interrupted)"
    } else {
        ""
    };
    let percent = |error: f64| {
        if error.is_finite() {
            format!("{:.2} %", 100.0 * error)
        } else {
            "unknown".to_owned()
        }
    };
    let errors = rendering.errors();
    let error = (0..rendering.components())
        .map(|k| format!("S{k} {}", percent(errors[k])))
        .collect::<Vec<_>>()
        .join(", ");
    eprintln!(
        "{}: {} spp{stopped}, errors {error}, {:.2} Mpaths/s, {:.1} s",
        output.display(),
        rendering.mean_samples().round(),
        rendering.counters.paths as f64 / rendering.wall.as_secs_f64().max(1e-9) / 1e6,
        elapsed.as_secs_f64()
    );
    if rendering.rejected > 0 {
        eprintln!(
            "warning: {} of {} samples were not finite and count as black; a radiance or a size beyond single precision?",
            rendering.rejected, rendering.samples
        );
    }
}

fn print_json(rendering: &Rendering, threads: usize, wall: Duration, cpu: Duration) {
    let rate = |count: u64| count as f64 / rendering.wall.as_secs_f64().max(1e-9);
    let line = serde_json::json!({
        "paths": rendering.counters.paths,
        "rays": rendering.counters.rays,
        "samples": rendering.mean_samples().round() as u64,
        "paths_per_s": rate(rendering.counters.paths),
        "rays_per_s": rate(rendering.counters.rays),
        "sampling_wall_s": rendering.wall.as_secs_f64(),
        "sampling_cpu_s": rendering.cpu.as_secs_f64(),
        "wall_s": wall.as_secs_f64(),
        "total_cpu_s": cpu.as_secs_f64(),
        "threads": threads,
        "error": rendering.error(),
        "errors": &rendering.errors()[..rendering.components()],
        "rejected": rendering.rejected,
        "interrupted": rendering.interrupted,
    });
    super::say(&format!("{line}\n"));
}
