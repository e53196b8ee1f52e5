//! The file of a checkpoint: a header, then records that are appended.
//!
//! | part | contents (integers little-endian) |
//! |---|---|
//! | header | magic (16 bytes), digest of the render (32), length of the identity (u64), identity (a manifest as JSON), SHA-256 of all that (32) |
//! | record | kind, number and count of values of the tile, three counts of rays (u64 each), SHA-256 of the values (32), SHA-256 of the digest of the render and the preceding 80 bytes (32), then the values (f32) |
//!
//! A record whose own digest is wrong ends the file: it was being written when the process or the machine stopped, and
//! is cut off before the next one is appended. Values are compared with their digest when they are read.
//!
//! The name can be foretold, so the file of that name may be anybody's. Only a regular file without other names is opened,
//! and only one that is empty or begins with the magic is written.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};

use holo_io::{Folder, Manifest, Sha256};
use holo_render::{FinishedTile, RayCounts, TileId, TileKind};

use super::Key;
use crate::output::{CHECKPOINT, CHECKPOINT_MAGIC as MAGIC};

/// The bytes of a record before its values.
const RECORD_BYTES: usize = 6 * 8 + 32 + 32;

/// A longer identity is none of this program.
const MAX_IDENTITY_BYTES: u64 = 1 << 20;

/// The name of the checkpoint of a render.
pub(super) fn name(digest: &Sha256) -> String {
    let [prefix, suffix] = CHECKPOINT;
    format!("{prefix}{}{suffix}", &digest.to_string()[..16])
}

/// A record, without its values.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    rays: RayCounts,
    count: u64,
    values: Sha256,
    /// Where its values begin.
    position: u64,
}

/// The records of an earlier run.
pub(super) struct Earlier {
    pub entries: HashMap<TileId, Entry>,
    file: File,
}

/// A file that is appended to.
pub(super) struct CheckpointFile {
    file: File,
    digest: Sha256,
    length: u64,
}

/// The result of [`open`].
pub(super) struct Opened {
    pub earlier: Earlier,
    /// For what follows.
    pub file: CheckpointFile,
    /// Bytes at the end that are no record, and were cut off.
    pub damaged: u64,
}

/// Opens the checkpoint of the render `key`, finds its records and cuts off what is damaged at its end.
///
/// # Errors
/// If it cannot be read, is of another render, or is in use by another process.
pub(super) fn open(folder: &Folder, name: &str, key: &Key) -> io::Result<Opened> {
    let file = lock(folder, name, false)?;
    let available = file.metadata()?.len();
    let mut reader = BufReader::new(&file);
    let (digest, _) = read_header(&mut reader)?;
    if digest != key.digest {
        return Err(io::Error::other("it is of another render"));
    }
    let mut entries = HashMap::new();
    let mut length = reader.stream_position()?;
    while let Some((id, entry)) = read_record(&mut reader, &digest, length, available) {
        length = entry.position + 4 * entry.count;
        reader.seek_relative(i64::try_from(4 * entry.count).map_err(io::Error::other)?)?;
        // A tile is repeated if its values were damaged: the later record counts.
        entries.insert(id, entry);
    }
    let damaged = available - length;
    file.set_len(length)?;
    let earlier = Earlier { entries, file: folder.open_regular(name, u64::MAX).map_err(io::Error::other)? };
    Ok(Opened { earlier, file: CheckpointFile { file, digest, length }, damaged })
}

/// Reads the identity of the render that a checkpoint is of; `None` if the header is damaged.
pub(super) fn identity(folder: &Folder, name: &str) -> Option<Manifest> {
    let file = folder.open_regular(name, u64::MAX).ok()?;
    let (_, identity) = read_header(&mut BufReader::new(file)).ok()?;
    Manifest::from_json(&identity).ok()
}

/// Opens a file, which is created if that is wanted, and takes its lock, by which another process sees that it is in use.
fn lock(folder: &Folder, name: &str, create: bool) -> io::Result<File> {
    let file = folder.open_own(name, create).map_err(io::Error::other)?;
    match file.try_lock() {
        Err(std::fs::TryLockError::WouldBlock) => Err(io::Error::other("another process renders the same")),
        // A file system without locks.
        _ => Ok(file),
    }
}

/// Reads the header; returns the digest of the render and its identity.
fn read_header(reader: &mut impl Read) -> io::Result<(Sha256, String)> {
    let damaged = || io::Error::other("its header is damaged");
    let mut header = vec![0; 56];
    reader.read_exact(&mut header).map_err(|_| damaged())?;
    let length = u64_at(&header, 48);
    if header[..16] != MAGIC[..] || length > MAX_IDENTITY_BYTES {
        return Err(damaged());
    }
    header.resize(56 + length as usize, 0);
    let mut check = [0; 32];
    reader.read_exact(&mut header[56..]).and_then(|()| reader.read_exact(&mut check)).map_err(|_| damaged())?;
    if Sha256::of(&header) != Sha256(check) {
        return Err(damaged());
    }
    let identity = String::from_utf8(header.split_off(56)).map_err(|_| damaged())?;
    Ok((sha256_at(&header, 16), identity))
}

/// Reads the record at `position` up to its values; `None` if it is damaged or incomplete.
fn read_record(reader: &mut impl Read, digest: &Sha256, position: u64, available: u64) -> Option<(TileId, Entry)> {
    let mut record = [0; RECORD_BYTES];
    reader.read_exact(&mut record).ok()?;
    let (fields, check) = record.split_at(RECORD_BYTES - 32);
    if record_digest(digest, fields) != sha256_at(check, 0) {
        return None;
    }
    let [kind, number, count, primary, shadow, secondary] = [0, 1, 2, 3, 4, 5].map(|k| u64_at(fields, 8 * k));
    let id = TileId { kind: kind_of(kind)?, number: usize::try_from(number).ok()? };
    let rays = RayCounts { primary, shadow, secondary };
    let entry = Entry { rays, count, values: sha256_at(fields, 48), position: position + RECORD_BYTES as u64 };
    let end = count.checked_mul(4)?.checked_add(entry.position)?;
    (end <= available).then_some((id, entry))
}

impl Earlier {
    /// Reads the values of a tile, as bytes.
    pub fn payload(&mut self, entry: &Entry) -> io::Result<Vec<u8>> {
        // Not above the size of the file: `read_record` has compared them.
        let mut bytes = vec![0; usize::try_from(4 * entry.count).map_err(io::Error::other)?];
        self.file.seek(SeekFrom::Start(entry.position))?;
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

impl Entry {
    /// The tile with these values; `None` if they are damaged.
    pub fn decode(&self, id: TileId, bytes: &[u8]) -> Option<FinishedTile> {
        let (values, []) = bytes.as_chunks::<4>() else { return None };
        let is_whole = Sha256::of(bytes) == self.values;
        let values = || values.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        is_whole.then(|| FinishedTile { id, rays: self.rays, values: values() })
    }
}

impl CheckpointFile {
    /// Creates the checkpoint of the render `key`, in place of one that is damaged.
    pub fn create(folder: &Folder, name: &str, key: &Key) -> io::Result<Self> {
        // Truncated once it is locked.
        let mut file = lock(folder, name, true)?;
        let mut begin = Vec::new();
        Read::by_ref(&mut file).take(MAGIC.len() as u64).read_to_end(&mut begin)?;
        if !begin.is_empty() && begin != MAGIC {
            let path = folder.path_of(name);
            let what = format!("{} is no checkpoint of this program; remove it", path.display());
            return Err(io::Error::other(what));
        }
        file.rewind()?;
        let identity = key.identity.to_json().map_err(io::Error::other)?;
        let mut header =
            [&MAGIC[..], &key.digest.0, &(identity.len() as u64).to_le_bytes(), identity.as_bytes()].concat();
        header.extend(Sha256::of(&header).0);
        file.set_len(0)?;
        file.write_all(&header)?;
        file.sync_all()?;
        // So that the name survives a power failure too. Not every system can sync folders.
        let _ = folder.sync(name);
        Ok(Self { file, digest: key.digest, length: header.len() as u64 })
    }

    /// Its size in bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Appends tiles and syncs. After an error the file ends as before, to leave the space to others.
    pub fn append(&mut self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> io::Result<()> {
        let before = self.length;
        let outcome = self.write(tiles).and_then(|()| self.file.sync_data());
        if outcome.is_err() {
            self.length = before;
            let _ = self.file.set_len(before);
        }
        outcome
    }

    fn write(&mut self, tiles: &mut dyn Iterator<Item = FinishedTile>) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.length))?;
        for tile in tiles {
            let record = record(&self.digest, &tile);
            self.file.write_all(&record)?;
            self.length += record.len() as u64;
        }
        Ok(())
    }
}

/// The bytes of a record.
fn record(digest: &Sha256, tile: &FinishedTile) -> Vec<u8> {
    let RayCounts { primary, shadow, secondary } = tile.rays;
    let values: Vec<u8> = tile.values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let fields = [number_of(tile.id.kind), tile.id.number as u64, tile.values.len() as u64, primary, shadow, secondary];
    let mut record: Vec<u8> = Vec::with_capacity(RECORD_BYTES + values.len());
    record.extend(fields.iter().flat_map(|field| field.to_le_bytes()));
    record.extend(Sha256::of(&values).0);
    record.extend(record_digest(digest, &record).0);
    record.extend(values);
    record
}

/// The digest of the fields of a record. It contains the render, so that no other file's record is taken for one of
/// this.
fn record_digest(digest: &Sha256, fields: &[u8]) -> Sha256 {
    Sha256::of(&[&digest.0, fields].concat())
}

const KINDS: [TileKind; 3] = [TileKind::Color, TileKind::AllLayers, TileKind::CentralLayers];

fn number_of(kind: TileKind) -> u64 {
    // A kind that this version does not know has a number that is never read back.
    KINDS.iter().position(|known| *known == kind).unwrap_or(KINDS.len()) as u64
}

fn kind_of(number: u64) -> Option<TileKind> {
    KINDS.get(usize::try_from(number).ok()?).copied()
}

/// The integer at a position; the bytes must be there.
fn u64_at(bytes: &[u8], position: usize) -> u64 {
    let mut integer = [0; 8];
    integer.copy_from_slice(&bytes[position..position + 8]);
    u64::from_le_bytes(integer)
}

/// The digest at a position; the bytes must be there.
fn sha256_at(bytes: &[u8], position: usize) -> Sha256 {
    let mut digest = [0; 32];
    digest.copy_from_slice(&bytes[position..position + 32]);
    Sha256(digest)
}
