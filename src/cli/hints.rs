//! What the command adds to the library's errors, which know causes and no flags: the flag that
//! an error is about goes before it, and the flags that help after it.

use crate::error::{ChoiceError, Error, EvaluateError, Origin, Remedy, ScoreError, SweepError};
use edgegait_core::silhouette::Size;
use std::fmt;

/// An error as the command shows it.
pub struct Shown<'a>(pub &'a Error);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(error) = self;
        write!(f, "{}{error}", flag(error))?;
        way_out(error).map_or(Ok(()), |way_out| write!(f, " ({way_out})"))
    }
}

/// The flag that an error is about, and its value; only the dashes where the message begins with
/// the flag's name.
fn flag(error: &Error) -> String {
    use ChoiceError as C;
    match error {
        Error::Choice(error) => match error {
            C::Distance(metres) => format!("--distance-m {metres}: "),
            C::FieldOfView(degrees) => format!("--fov-deg {degrees}: "),
            C::Aim(place) => format!("--aim-m {place}: "),
            C::ColumnsShareScale { .. }
            | C::ColumnsSumFrames(_)
            | C::ColumnsFrames(_)
            | C::RasterUnderCondition { .. }
            | C::GreyRaster(_)
            | C::EmbeddedProvider(_)
            | C::Provider { .. } => "--".into(),
            C::NoImage(_) => "--augment: ".into(),
            C::Crops { steps, rows, .. } => format!("--crop-steps {steps} --crop-rows {rows}: "),
            C::NotMeasured { .. } | C::TakeHasNoGei { .. } => "--max-gei-rmse: ".into(),
            C::CyclesAreRecorded(_) => "--cycles: ".into(),
            C::NoLibrary { .. } => "--runtime ort: ".into(),
            C::BareEmbedded => "--bare: ".into(),
            C::Processors { .. } => "--cpus: ".into(),
            _ => String::new(),
        },
        Error::Sweep(SweepError::GeiError { asked, .. }) => format!("--max-gei-rmse {asked}: "),
        _ => String::new(),
    }
}

/// What to do about a model that the embedded runtime does not run.
const OTHER_RUNTIME: &str = "use --runtime ort --ort-lib PATH";

/// What to do, in flags.
fn way_out(error: &Error) -> Option<String> {
    use ChoiceError as C;
    let words = match error {
        Error::Input {
            remedy: Some(remedy),
            ..
        } => match remedy {
            Remedy::OnnxRuntime => OTHER_RUNTIME,
            Remedy::NameAnimation => "use --clip",
            Remedy::FolderIsSubject => {
                "--subject-from folder takes the folder's name as the subject's"
            }
            Remedy::FrameAnew => "do without --as-stored",
        },
        Error::Score(error) => return asked(error),
        Error::Choice(error) => match error {
            C::CycleNeedsParallelRays => "use --lens ortho, or --framing camera",
            C::ColumnsShareScale { setting, value, .. } => {
                return Some(format!(
                    "use --raster rows, or another than --{setting} {value}"
                ));
            }
            C::ColumnsSumFrames(_) => "use --raster rows",
            C::ColumnsFrames(_) => "--frames-per-cycle",
            C::RasterUnderCondition { .. } => "use --raster skia or rows",
            C::NotMeasured { .. } => "choose --raster, --jitter and --frames-per-cycle yourself",
            C::TakeHasNoGei { .. } => "leave out --track clip, or use --max-error-mm",
            C::NoCondition { .. } => "--conditions",
            C::NoLibrary { .. } => "--ort-lib names it",
            C::EmbeddedProvider(_) | C::BareEmbedded => "use --runtime ort",
            C::ForeignDataset(_) => "name another folder, or use --overwrite",
            _ => return None,
        },
        Error::Sweep(error) => match error {
            SweepError::TakeHasNoCycle(_) => {
                "import it without --track clip, or choose others with --walks"
            }
            SweepError::TakeHasNoVariations(_) => "leave out --cycle",
            _ => return None,
        },
        Error::Evaluate(error) => match error {
            EvaluateError::NoTake { .. } => {
                "rename takes, choose one walk of each person so that takes are made of it, or another --protocol"
            }
            EvaluateError::NoClass { .. } => "use --protocol first-take",
            EvaluateError::TooManyViews { .. } => "choose fewer with --views",
            _ => return None,
        },
        _ => return None,
    };
    Some(words.to_owned())
}

/// What a recognizer asks for, in flags.
fn asked(error: &ScoreError) -> Option<String> {
    match error {
        ScoreError::Contract { setting, asked, .. }
            if *setting == "size" && Size::ALL.iter().all(|size| size.name() != asked) =>
        {
            Some("only 50x30, 64x44 and 64x64 can be drawn".into())
        }
        ScoreError::Contract {
            setting,
            asked,
            origin,
            ..
        } => {
            let what = match origin {
                Origin::Drawn => "use",
                Origin::Dataset => "sweep another dataset with",
            };
            Some(format!("{what} --{setting} {asked}"))
        }
        ScoreError::Embedded { .. } => Some(format!("if the model is right, {OTHER_RUNTIME}")),
        _ => None,
    }
}
