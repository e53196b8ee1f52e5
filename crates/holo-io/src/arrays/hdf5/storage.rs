//! What a file may refer to: nothing outside of itself.
//!
//! A dataset of HDF5 may lie in any other file: as external storage, behind an external link, or as the source of a virtual
//! dataset. The library opens these files when values are read, whatever they are and wherever they lie, so that the bytes
//! of `/etc/passwd` become pixels. An unknown filter makes it load a library. So every dataset that is read here is found by
//! links that lie in the file, and the place of its values is checked before anything else is read.

use std::path::Path;

use ::hdf5::dataset::Layout;
use ::hdf5::filters::Filter;
use ::hdf5::{Dataset, File, Group, LinkType};

use super::library::Failure;
use crate::Error;
use crate::records::dataset::{LIGHT_FIELD_HDF5, SequenceFolder};

/// Deflate makes at most so many bytes of one (zlib manual, "Maximum Compression Factor").
const MAX_RATIO: u64 = 1032;

/// Values that a file does not store are zeros or the like, and more of them than these take memory for nothing.
const MAX_SPARSE_BYTES: u64 = 64 << 20;

/// Finds a dataset of a file by its name, of one or two parts; `None` if there is none. Its values may be read, unless it
/// [is virtual](check_values).
///
/// # Errors
///
/// [`Error::Unsupported`] if a part of the name is no plain link into the file, the values lie elsewhere, or a filter is not
/// one of those that this crate reads.
pub(crate) fn find(file: &File, path: &Path, name: &str) -> Result<Option<Dataset>, Error> {
    match name.split_once('/') {
        None => in_group(file, path, name, name),
        Some((outer, inner)) => {
            if !has_link(file, path, outer, outer)? {
                return Ok(None);
            }
            let Ok(group) = file.group(outer) else { return Ok(None) };
            in_group(&group, path, inner, name)
        }
    }
}

/// The members of the root group, each with its dataset, if it is one; without those whose names begin with `#`, in which
/// MATLAB keeps parts of others.
///
/// # Errors
///
/// Those of [`find`], for any of them.
pub(crate) fn members(file: &File, path: &Path) -> Result<Vec<(String, Option<Dataset>)>, Error> {
    let mut links = Vec::new();
    let visited = file.iter_visit_default(|name, info| {
        if !name.starts_with('#') {
            links.push((name.to_owned(), info.link_type));
        }
        Ok(())
    });
    visited.map_err(|error| Failure { path, is_writing: false }.error(error))?;
    let member = |(name, link): (String, LinkType)| {
        check_link(link, path, &name)?;
        let dataset = opened(file, path, &name, &name)?;
        Ok((name, dataset))
    };
    links.into_iter().map(member).collect()
}

fn in_group(group: &Group, path: &Path, part: &str, name: &str) -> Result<Option<Dataset>, Error> {
    if !has_link(group, path, part, name)? {
        return Ok(None);
    }
    opened(group, path, part, name)
}

/// Opens a dataset behind a link that was checked; `None` if it is something else.
fn opened(group: &Group, path: &Path, part: &str, name: &str) -> Result<Option<Dataset>, Error> {
    let Ok(dataset) = group.dataset(part) else { return Ok(None) };
    check_storage(&dataset, path, name)?;
    Ok(Some(dataset))
}

/// Whether a group has a link of this name, which must be one into the file.
fn has_link(group: &Group, path: &Path, part: &str, name: &str) -> Result<bool, Error> {
    let mut found = None;
    let visited = group.iter_visit_default(|own, info| {
        if own == part {
            found = Some(info.link_type);
        }
        Ok(())
    });
    visited.map_err(|error| Failure { path, is_writing: false }.error(error))?;
    found.map_or(Ok(false), |link| check_link(link, path, name).map(|()| true))
}

fn check_link(link: LinkType, path: &Path, name: &str) -> Result<(), Error> {
    match link {
        LinkType::Hard => Ok(()),
        // A symbolic link may lead to an external one.
        LinkType::Soft | LinkType::External => {
            let what = "a link to another place; only what lies in the file itself is read. Copy it into the file";
            Err(refused(path, name, what))
        }
    }
}

/// Checks where the values of a dataset lie, and what encodes them.
fn check_storage(dataset: &Dataset, path: &Path, name: &str) -> Result<(), Error> {
    let failed = |error| Failure { path, is_writing: false }.error(error);
    let created = dataset.dcpl().map_err(failed)?;
    if created.get_layout().map_err(failed)? == Layout::Virtual {
        // The crate cannot represent every selection. The values are not read in any case: see `check_values`.
        let Ok(sources) = created.get_virtual_map() else { return Ok(()) };
        return match sources.iter().all(|source| is_of_frame(&source.src_filename)) {
            true => Ok(()),
            false => Err(refused(path, name, "put together of other files; copy them into this one")),
        };
    }
    if !created.get_external().map_err(failed)?.is_empty() {
        return Err(refused(path, name, "in other files; copy it into this one"));
    }
    for filter in created.get_filters().map_err(failed)? {
        if !matches!(filter, Filter::Deflate(_) | Filter::Shuffle | Filter::Fletcher32) {
            let what = "compressed in a way that is not read; gzip and shuffle are, which `h5repack -f GZIP=1` makes";
            return Err(refused(path, name, what));
        }
    }
    let value_bytes = dataset.dtype().map_err(failed)?.size();
    let announced = (dataset.size() as u64).saturating_mul(value_bytes as u64);
    let stored = dataset.storage_size();
    if announced > MAX_SPARSE_BYTES && stored.saturating_mul(MAX_RATIO) < announced {
        let what = format!("of {announced} bytes, and the file stores {stored} of them; write all of its values");
        return Err(refused(path, name, &what));
    }
    Ok(())
}

/// Checks that the values of a dataset lie in the file: virtual datasets are those of a sequence, whose frames are read one
/// by one.
pub(crate) fn check_values(dataset: &Dataset, path: &Path) -> Result<(), Error> {
    let failed = |error| Failure { path, is_writing: false }.error(error);
    let layout = dataset.dcpl().and_then(|created| created.get_layout()).map_err(failed)?;
    match layout {
        Layout::Virtual => Err(Error::unsupported(path, "its values are in other files; read these")),
        _ => Ok(()),
    }
}

/// Whether a source of a virtual dataset is the file of a frame below the folder of the sequence.
fn is_of_frame(source: &str) -> bool {
    let Some((folder, file)) = source.split_once('/') else { return false };
    let frame = folder.strip_prefix("frame_").and_then(|digits| digits.parse().ok());
    file == LIGHT_FIELD_HDF5 && frame.is_some_and(|frame| SequenceFolder::frame_name(frame) == folder)
}

fn refused(path: &Path, name: &str, what: &str) -> Error {
    Error::unsupported(path, format!("/{} is {what}", crate::shown(name)))
}

#[cfg(test)]
mod tests {
    use ::hdf5::{Hyperslab, SliceOrIndex};
    use ndarray::Array5;

    use super::*;
    use crate::{Hdf5LightField, Limits};

    /// Writes `/H` into a file; the paths are those of another file and of a secret.
    type Make = fn(&File, &str, &str) -> ::hdf5::Result<()>;

    const SHAPE: [usize; 5] = [4, 4, 2, 2, 1];

    fn own(file: &File, _: &str, _: &str) -> ::hdf5::Result<()> {
        file.new_dataset_builder().with_data(&Array5::<u8>::ones(SHAPE)).create("H").map(drop)
    }

    fn external_storage(file: &File, _: &str, secret: &str) -> ::hdf5::Result<()> {
        file.new_dataset::<u8>().shape(SHAPE).external(secret, 0, 64).create("H").map(drop)
    }

    fn external_link(file: &File, other: &str, _: &str) -> ::hdf5::Result<()> {
        file.link_external(other, "H", "H")
    }

    fn link_to_a_link(file: &File, other: &str, _: &str) -> ::hdf5::Result<()> {
        file.link_external(other, "H", "real")?;
        file.link_soft("/real", "H")
    }

    fn virtual_dataset(file: &File, other: &str, _: &str) -> ::hdf5::Result<()> {
        let whole = || Hyperslab::from(SHAPE.map(|count| SliceOrIndex::from(0..count)).to_vec());
        let (from, to) = (SHAPE.to_vec(), SHAPE.to_vec());
        let builder = file.new_dataset::<u8>().shape(SHAPE);
        builder.virtual_map(other, "/H", &from, whole(), &to, whole()).create("H").map(drop)
    }

    #[test]
    fn values_that_lie_elsewhere_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [other, secret] = ["other.h5", "secret"].map(|name| folder.path().join(name));
        std::fs::write(&secret, [7; 64]).unwrap();
        let [other_name, secret_name] = [&other, &secret].map(|path| path.to_str().unwrap());
        let make = |path: &Path, make: Make| {
            let file = File::create(path).unwrap();
            make(&file, other_name, secret_name).unwrap();
            file.close().unwrap();
        };
        make(&other, own);
        let limits = Limits::default();
        assert!(Hdf5LightField::open(&other, &limits).unwrap().read().is_ok());
        let cases: [(&str, Make); 4] = [
            ("external storage", external_storage),
            ("external link", external_link),
            ("link to a link", link_to_a_link),
            ("virtual dataset", virtual_dataset),
        ];
        for (name, case) in cases {
            let path = folder.path().join(format!("{name}.h5"));
            make(&path, case);
            let error = Hdf5LightField::open(&path, &limits).unwrap_err();
            assert!(matches!(error, Error::Unsupported { .. }), "{name}: {error}");
            assert!(crate::is_light_field_hdf5(&path).is_err(), "{name}");
        }
    }

    /// A file of some kilobytes announces 3.9 GB.
    #[test]
    fn values_that_are_not_stored_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sparse.h5");
        let file = File::create(&path).unwrap();
        let shape = [8, 8, 4500, 4500, 3];
        file.new_dataset::<u8>().shape(shape).chunk([1, 1, 450, 450, 3]).deflate(9).create("H").unwrap();
        file.close().unwrap();
        assert!(path.metadata().unwrap().len() < 10_000);
        let error = Hdf5LightField::open(&path, &Limits::default()).unwrap_err();
        assert!(matches!(error, Error::Unsupported { .. }) && error.to_string().contains("3888000000"), "{error}");
    }

    #[test]
    fn sources_of_a_sequence_are_files_of_frames() {
        assert!(is_of_frame("frame_0000/scene_5d.h5") && is_of_frame("frame_12345/scene_5d.h5"));
        for other in [
            "",
            ".",
            "scene_5d.h5",
            "/etc/passwd",
            "../frame_0000/scene_5d.h5",
            "frame_0000/../scene_5d.h5",
            "frame_0/scene_5d.h5",
            "frame_0000/other.h5",
            "frame_%b/scene_5d.h5",
        ] {
            assert!(!is_of_frame(other), "{other}");
        }
    }
}
