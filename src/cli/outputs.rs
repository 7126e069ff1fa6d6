use std::fs;
use std::path::{Path, PathBuf};

use super::args::BakeArgs;
use super::failure::Failure;

/// Where results go.
#[derive(Debug)]
pub(super) struct Outputs {
    pub(super) glb: PathBuf,
    pub(super) preview: Option<PathBuf>,
    pub(super) report: Option<PathBuf>,
}

impl Outputs {
    /// Looks before the bake at everything that could stop its results from being written.
    pub(super) fn new(args: &BakeArgs) -> Result<Self, Failure> {
        let outputs = Self {
            glb: (args.output.clone()).unwrap_or_else(|| args.scene.with_extension("baked.glb")),
            preview: args.results.preview.clone(),
            report: args.results.report.clone(),
        };
        extension(&outputs.glb, &["glb"], "the result is binary glTF")?;
        if let Some(preview) = &outputs.preview {
            extension(preview, &["png"], "the preview is a PNG image")?;
        }
        all_writable(&outputs.all().collect::<Vec<_>>())?;
        outputs.spare(std::slice::from_ref(&args.scene))?;
        Ok(outputs)
    }

    /// An error if a result would replace one of the files it is made from.
    pub(super) fn spare(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        for path in self.all() {
            if inputs.iter().any(|input| same(path, input)) {
                return Err(Failure::Error(format!(
                    "{} is part of the scene and would be overwritten: choose another name (-o, \
                     --preview, --report)",
                    path.display()
                )));
            }
        }
        Ok(())
    }

    fn all(&self) -> impl Iterator<Item = &Path> {
        [Some(&self.glb), self.preview.as_ref(), self.report.as_ref()]
            .into_iter()
            .flatten()
            .map(PathBuf::as_path)
    }
}

/// An error unless the name ends in one of the extensions; `what` says why it has to.
pub(super) fn extension(path: &Path, wanted: &[&str], what: &str) -> Result<(), Failure> {
    let found = path.extension().unwrap_or_default();
    let fits = wanted.iter().any(|w| found.eq_ignore_ascii_case(w));
    // A device has no extension: /dev/null is a fine place for a result nobody wants.
    if fits || (path.exists() && !path.is_file()) {
        return Ok(());
    }
    Err(Failure::Error(format!(
        "{}: {what}, let its name end in .{}",
        path.display(),
        wanted.join(" or .")
    )))
}

/// An error if a result cannot be written, or if two would go to one file.
pub(super) fn all_writable(paths: &[&Path]) -> Result<(), Failure> {
    for (i, path) in paths.iter().enumerate() {
        writable(path)?;
        if paths[i + 1..].iter().any(|other| same(path, other)) {
            return Err(Failure::Error(format!(
                "two results would go to {}: give them different names",
                path.display()
            )));
        }
    }
    Ok(())
}

fn writable(path: &Path) -> Result<(), Failure> {
    let folder = folder(path);
    let problem = if !folder.is_dir() {
        format!(
            "there is no folder {}: create it, or choose another",
            folder.display()
        )
    } else if path.is_dir() {
        "it is a folder: name a file".to_owned()
    } else {
        return Ok(());
    };
    Err(Failure::Error(format!(
        "cannot write {}: {problem}",
        path.display()
    )))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Whether two paths lead to one file, which need not exist yet.
pub(super) fn same(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| -> Option<PathBuf> {
        if let Ok(real) = fs::canonicalize(path) {
            return Some(real);
        }
        let folder = fs::canonicalize(folder(path)).ok()?;
        Some(folder.join(path.file_name()?))
    };
    a == b || real(a).is_some_and(|a| Some(a) == real(b))
}
