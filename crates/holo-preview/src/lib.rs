//! Shows a scene live in a browser while its holoscopic camera is set up.
//!
//! ```text
//! page (state) -> socket -> studio (scene, world, renderer) -> images -> socket -> page
//! ```
//!
//! The page holds all of the state: every message has the whole of it, as settings of [`holo_dataset`] in text. The newest
//! message wins; what is drawn for an older one ends. It keeps one world as long as the scene stays the same.
//!
//! # Security
//! The server listens on the computer itself unless another address is given. Requests need the token of the
//! [address](Server::address), and headers `Host` and `Origin` of this server, so that no other page can use it. The page
//! cannot name files: see [`Preview`].

// The macro `s` of ndarray allows itself what `forbid` would not.
#![deny(unsafe_code)]
#![warn(missing_docs)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod draw;
mod encode;
mod estimate;
mod job;
mod pace;
mod protocol;
mod raw_part;
mod render;
mod server;
mod studio;

use std::io;
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

use holo_dataset::settings::Given;
use holo_dataset::{EngineSettings, Rollback, SceneSource};
use holo_io::{CameraArray, CameraFile};

pub use server::Server;

/// An error of starting the server.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}; choose another port")]
    Listen {
        /// Address and port.
        address: String,
        /// The error of the system.
        source: io::Error,
    },
    /// The system has no random numbers for the token.
    #[error("the system gives no random numbers: {0}")]
    Random(String),
    /// The server cannot accept connections any more.
    #[error("the server ended: {0}")]
    Serve(#[from] io::Error),
}

/// What a page may show and write. The default shows the first scene of the gallery, and writes nothing.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Preview {
    /// The scene; `None`: a page that begins with the gallery.
    pub scene: Option<SceneSource>,
    /// The plenoptic camera that the page begins with; `None`: a rig.
    pub camera: Option<CameraFile>,
    /// Poses that the page offers to look from.
    pub poses: Option<CameraArray>,
    /// The settings that the page begins with. A sky that is a file is possible only here.
    pub given: Given,
    /// The folder that renders of the page are put into, each in a new folder of its own; `None`: the page cannot render.
    pub out: Option<PathBuf>,
    /// The files that a render has put into its folder: who ends the process early removes them.
    pub rollback: Rollback,
    /// The ray tracing backend and the number of threads.
    pub engine: EngineSettings,
    /// The address to listen on.
    pub listen: IpAddr,
}

impl Default for Preview {
    fn default() -> Self {
        Self {
            scene: None,
            camera: None,
            poses: None,
            given: Given::default(),
            out: None,
            rollback: Rollback::default(),
            engine: EngineSettings::default(),
            listen: IpAddr::V4(Ipv4Addr::LOCALHOST),
        }
    }
}

impl Preview {
    /// Creates the default preview.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the scene.
    #[must_use]
    pub fn scene(self, scene: impl Into<Option<SceneSource>>) -> Self {
        Self { scene: scene.into(), ..self }
    }

    /// Sets the plenoptic camera.
    #[must_use]
    pub fn camera(self, camera: impl Into<Option<CameraFile>>) -> Self {
        Self { camera: camera.into(), ..self }
    }

    /// Sets the poses that the page offers. It stands where they do, with their angles of view where it shows a rig; their gains
    /// and times do not show.
    #[must_use]
    pub fn poses(self, poses: impl Into<Option<CameraArray>>) -> Self {
        Self { poses: poses.into(), ..self }
    }

    /// Sets the settings that the page begins with.
    #[must_use]
    pub fn given(self, given: Given) -> Self {
        Self { given, ..self }
    }

    /// Sets the folder that renders are put into.
    #[must_use]
    pub fn out(self, out: impl Into<Option<PathBuf>>) -> Self {
        Self { out: out.into(), ..self }
    }

    /// Sets the list of files that are removed if the process ends early.
    #[must_use]
    pub fn rollback(self, rollback: &Rollback) -> Self {
        Self { rollback: rollback.clone(), ..self }
    }

    /// Sets the ray tracing backend and the number of threads.
    #[must_use]
    pub fn engine(self, engine: EngineSettings) -> Self {
        Self { engine, ..self }
    }

    /// Sets the address to listen on: other computers reach the page if it is not that of this computer alone.
    #[must_use]
    pub fn listen(self, listen: IpAddr) -> Self {
        Self { listen, ..self }
    }

    /// Binds a port; 0 takes a free one.
    ///
    /// # Errors
    /// [`Error::Listen`] if the port is taken or not permitted; [`Error::Random`] if the system gives no random numbers.
    pub fn bind(self, port: u16) -> Result<Server, Error> {
        Server::bind(self, port)
    }
}
