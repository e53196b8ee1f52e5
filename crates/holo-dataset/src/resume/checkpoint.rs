//! Checkpoints: finished parts of a long render are kept on disk while it runs, so that the same job continues after an
//! interruption, to the same bytes.
//!
//! What is kept are tiles of linear radiance and of layers, before exposure and encoding. They are in one file a render,
//! [beside its output](Checkpoints::folder), whose name contains the digest of everything that determines them: the
//! scene with its textures, the environment map, the camera, the settings, the ray tracing backend and the program. A
//! file of another digest is never read beyond its header.
//!
//! The file is appended to and synced every [`Checkpoints::every`], for the first time after that time: a short render
//! writes none. It is removed when the output folder is complete.

mod file;
mod fingerprint;

use std::fmt::Debug;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use holo_io::{Folder, Manifest, Sha256, dataset};
use holo_render::{Checkpoint, FinishedTile, TileId};
use holo_scene::Scene;

use self::file::{CheckpointFile, Earlier};
use super::identity::difference;
use crate::Error;
use crate::output::checkpoints as files;
use crate::watch::{About, Diagnostics};

/// Storing takes at most one part in this many of the time of one thread: the interval grows where the disk is slow.
const TIME_BETWEEN_OVER_TIME_OF_STORING: u32 = 20;

/// How often and where a render keeps its finished parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checkpoints {
    /// The time between two checkpoints, and before the first. An interruption loses at most twice this time, and the
    /// tiles that the threads were working on. Zero stores after every tile.
    pub every: Duration,
    /// The folder of the file; `None`: the output folder.
    pub folder: Option<PathBuf>,
}

impl Checkpoints {
    /// Checkpoints in the output folder with this interval, s; `None` for 0 and what is no interval.
    #[must_use]
    pub fn every_seconds(seconds: f64) -> Option<Self> {
        let every = Duration::try_from_secs_f64(seconds).ok().filter(|every| !every.is_zero())?;
        Some(Self { every, folder: None })
    }
}

impl Default for Checkpoints {
    /// Every 30 s in the output folder.
    fn default() -> Self {
        Self { every: Duration::from_secs(30), folder: None }
    }
}

/// What determines the tiles of a render.
pub(crate) struct Key {
    /// The digest of everything.
    pub digest: Sha256,
    /// The part that has names, for messages.
    pub identity: Manifest,
}

/// The checkpoint of one render.
pub(crate) struct Keeper<'a> {
    /// Where the file is, or why that folder cannot be opened.
    folder: Result<Folder, String>,
    every: Duration,
    start: Instant,
    /// Computed only if it is needed, because scene and program are hashed for it.
    key: LazyLock<Key, Box<dyn FnOnce() -> Key + Send + 'a>>,
    /// The tiles of an earlier run.
    earlier: Option<Mutex<Earlier>>,
    /// How many of them could not be read.
    damaged: AtomicU64,
    state: Mutex<State>,
}

/// The file, and when it was written.
struct State {
    file: Option<CheckpointFile>,
    /// The last checkpoint, or the begin of the render.
    last: Instant,
    /// The time that the last checkpoint took.
    took: Duration,
    /// Whether a thread stores tiles, which takes the file meanwhile.
    is_storing: bool,
    /// Why the last tiles could not be stored.
    failure: Option<String>,
}

impl<'a> Keeper<'a> {
    /// Opens the checkpoint of an earlier run of the same render, if there is one, and reports what it contains, and
    /// which others are not used. `request` is all that decides the tiles beside the scene, with the pose of the camera.
    pub fn open(
        checkpoints: &Checkpoints,
        out: &Folder,
        (scene, request): (&'a Scene, impl Debug + Send + 'a),
        identity: &Manifest,
        diagnostics: &dyn Diagnostics,
    ) -> Self {
        let identity = identity.clone();
        let key = move || Key { digest: fingerprint::of(scene, &request, &identity), identity };
        let start = Instant::now();
        let folder = match &checkpoints.folder {
            Some(path) => Folder::open(path).map_err(|why| why.to_string()),
            None => Ok(out.clone()),
        };
        let mut keeper = Self {
            folder: folder.clone(),
            every: checkpoints.every,
            start,
            key: LazyLock::new(Box::new(key)),
            earlier: None,
            damaged: AtomicU64::new(0),
            state: Mutex::new(State {
                file: None,
                last: start,
                took: Duration::ZERO,
                is_storing: false,
                failure: None,
            }),
        };
        if let Ok(folder) = folder {
            for name in files(&folder) {
                let line = keeper.read(&folder, &name);
                diagnostics.report(About::Scene, &line);
            }
        }
        keeper
    }

    /// Reads the checkpoint of a name, if it is of this render. Returns what to report.
    fn read(&mut self, folder: &Folder, own: &str) -> String {
        let path = folder.path_of(own);
        let name = path.display();
        if own != self.name() {
            let difference = file::identity(folder, own).and_then(|of| difference(&of, &self.key.identity));
            let why = difference.unwrap_or_else(|| "the scene, the camera, the part or the program is another".into());
            return format!("note: the checkpoint {name} is not used: {why}");
        }
        match file::open(folder, own, &self.key) {
            Ok(file::Opened { earlier, file, damaged }) => {
                let count = earlier.entries.len();
                let cut = if damaged > 0 {
                    format!("; {damaged} damaged bytes at its end are not used")
                } else {
                    String::new()
                };
                self.earlier = Some(Mutex::new(earlier));
                lock(&self.state).file = Some(file);
                format!("note: continues with {count} finished tiles of {name}{cut}")
            }
            Err(why) => format!("warning: the checkpoint {name} is not used: {why}"),
        }
    }

    /// The name of the file, whether it exists or not.
    fn name(&self) -> String {
        file::name(&self.key.digest)
    }

    /// Reports what went wrong while it was used and, of a render that `is_unfinished`, that it can be continued.
    pub fn report(&self, is_unfinished: bool, diagnostics: &dyn Diagnostics) {
        let damaged = self.damaged.load(Ordering::Relaxed);
        if damaged > 0 {
            diagnostics.report(About::Scene, &format!("warning: {damaged} tiles of the checkpoint were damaged"));
        }
        let state = lock(&self.state);
        if let Some(why) = &state.failure {
            diagnostics.report(About::Scene, &format!("warning: the last checkpoint could not be written: {why}"));
        }
        if let (Some(file), Ok(folder)) = (state.file.as_ref().filter(|_| is_unfinished), &self.folder) {
            let (path, megabytes) = (folder.path_of(&self.name()), file.length() as f64 / 1e6);
            let line = format!(
                "note: {} ({megabytes:.1} MB) has what is finished; the same command continues",
                path.display()
            );
            diagnostics.report(About::Scene, &line);
        }
    }

    /// Removes the file. Errors are ignored: such a file does no harm.
    pub fn remove(self) {
        let file = lock(&self.state).file.take();
        if let (Some(_), Ok(folder)) = (file, &self.folder) {
            let _ = folder.remove_file(&self.name());
        }
    }

    /// Appends tiles to the file, which is created first.
    fn append(
        &self,
        file: &mut Option<CheckpointFile>,
        tiles: &mut dyn Iterator<Item = FinishedTile>,
    ) -> io::Result<()> {
        let mut tiles = tiles.peekable();
        if tiles.peek().is_none() {
            return Ok(());
        }
        let file = match file {
            Some(file) => file,
            None => {
                let folder = self.folder.as_ref().map_err(|why| io::Error::other(why.clone()))?;
                file.insert(CheckpointFile::create(folder, &self.name(), &self.key)?)
            }
        };
        file.append(&mut tiles)
    }
}

impl Checkpoint for Keeper<'_> {
    fn contains(&self, id: TileId) -> bool {
        self.earlier.as_ref().is_some_and(|earlier| lock(earlier).entries.contains_key(&id))
    }

    fn restore(&self, id: TileId) -> Option<FinishedTile> {
        let mut earlier = lock(self.earlier.as_ref()?);
        let entry = *earlier.entries.get(&id)?;
        let bytes = earlier.payload(&entry);
        drop(earlier);
        // Compared with its digest while other threads read.
        let tile = bytes.ok().and_then(|bytes| entry.decode(id, &bytes));
        if tile.is_none() {
            self.damaged.fetch_add(1, Ordering::Relaxed);
        }
        tile
    }

    fn is_due(&self, done: u64, total: u64) -> bool {
        let mut state = lock(&self.state);
        let since = state.last.elapsed();
        let interval = self.every.max(state.took * TIME_BETWEEN_OVER_TIME_OF_STORING);
        // Not shortly before the end, as far as that can be known.
        let left = self.start.elapsed().mul_f64(total.saturating_sub(done) as f64 / done.max(1) as f64);
        let is_due = !state.is_storing && since >= interval && (left >= interval || since >= 2 * interval);
        state.is_storing |= is_due;
        is_due
    }

    fn wants_rest(&self) -> bool {
        let mut state = lock(&self.state);
        let wants_rest = state.file.is_some() && !state.is_storing;
        state.is_storing |= wants_rest;
        wants_rest
    }

    fn store(&self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> bool {
        // The first time this takes longer than what follows.
        LazyLock::force(&self.key);
        let start = Instant::now();
        let mut file = lock(&self.state).file.take();
        let outcome = self.append(&mut file, tiles);
        let mut state = lock(&self.state);
        *state = State {
            file,
            last: Instant::now(),
            took: start.elapsed(),
            is_storing: false,
            failure: outcome.err().map(|why| why.to_string()),
        };
        state.failure.is_none()
    }
}

/// The checkpoint of one of several images that share a file.
pub(crate) struct ImageKeeper<'a> {
    /// The checkpoint of all.
    pub all: &'a dyn Checkpoint,
    /// The number of the image, and how many there are.
    pub image: (usize, usize),
    /// The place of the image among those that this run renders, and how many these are.
    pub turn: (usize, usize),
}

impl ImageKeeper<'_> {
    /// The identity of a tile among those of all images.
    fn of_all(&self, id: TileId) -> TileId {
        let (image, count) = self.image;
        TileId { number: id.number * count + image, ..id }
    }
}

impl Checkpoint for ImageKeeper<'_> {
    fn contains(&self, id: TileId) -> bool {
        self.all.contains(self.of_all(id))
    }

    fn restore(&self, id: TileId) -> Option<FinishedTile> {
        Some(FinishedTile { id, ..self.all.restore(self.of_all(id))? })
    }

    fn is_due(&self, done: u64, total: u64) -> bool {
        let (turn, count) = self.turn;
        self.all.is_due(turn as u64 * total + done, count as u64 * total)
    }

    fn wants_rest(&self) -> bool {
        self.all.wants_rest()
    }

    fn store(&self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> bool {
        self.all.store(&mut tiles.map(|tile| FinishedTile { id: self.of_all(tile.id), ..tile }))
    }
}

/// A poisoned lock is used: what it protects is consistent after every statement.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Reads the manifest of a folder. Where there is none but a checkpoint, the error says that the render is unfinished.
pub(crate) fn finished_manifest(folder: &Folder) -> Result<Manifest, Error> {
    if folder.kind(dataset::MANIFEST_JSON)?.is_none() && !files(folder).is_empty() {
        let folder = folder.path().display();
        return Err(Error::Failed(format!(
            "{folder}: an unfinished render with a checkpoint; its command continues it"
        )));
    }
    Ok(Manifest::read_in(folder)?)
}
