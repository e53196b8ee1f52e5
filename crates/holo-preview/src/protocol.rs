//! The messages between page and server.
//!
//! The page sends JSON, and the bytes of a scene that was dropped on it. The server sends binary messages: the length of a
//! header as u32 (little endian), the header as JSON, and the bytes of an image or a map.

pub(crate) mod inbox;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use serde::Deserialize;
use serde_json::Value;

use inbox::Inbox;

/// A message of the page.
#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(crate) enum PageMessage {
    /// Show this.
    Look(Look),
    /// Render this into files.
    Render(Look),
    /// Stop the render that runs.
    Stop,
    /// Show all scenes of the gallery, small.
    Gallery,
    /// The next binary message is a scene of this name.
    Drop {
        /// The name of the file, for messages.
        name: String,
    },
}

/// The whole state of a page.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct Look {
    /// The number of the state, which answers have too.
    pub number: u64,
    /// The name of a scene of the gallery; empty: the scene that was named or dropped last.
    pub scene: String,
    /// The preset of a plenoptic camera; `own`: the camera that was named; empty: a rig.
    pub camera: String,
    /// Settings as text.
    pub settings: BTreeMap<String, String>,
    /// Width and height of the image, px.
    pub size: [usize; 2],
    /// Whether the camera moves: an image soon, and nothing else.
    pub moving: bool,
    /// Column and row of the microlens to show; `None`: the one in the middle.
    pub lens: Option<[usize; 2]>,
}

/// A message of the server.
#[derive(Debug)]
pub(crate) struct Reply {
    pub header: Value,
    pub payload: Vec<u8>,
}

impl Reply {
    pub fn new(header: Value) -> Self {
        Self { header, payload: Vec::new() }
    }

    pub fn with(header: Value, payload: Vec<u8>) -> Self {
        Self { header, payload }
    }

    /// The bytes of the message.
    pub fn bytes(&self) -> Vec<u8> {
        let header = self.header.to_string().into_bytes();
        let mut out = Vec::with_capacity(4 + header.len() + self.payload.len());
        // A header has a few kilobytes.
        out.extend_from_slice(&(header.len() as u32).to_le_bytes());
        out.extend_from_slice(&header);
        out.extend_from_slice(&self.payload);
        out
    }
}

/// What the owner of the socket waits for.
pub(crate) enum Event {
    /// Bytes from the network; none: the page is gone.
    Bytes(Vec<u8>),
    Send(Reply),
}

/// A page: what it has sent, and what it is sent.
pub(crate) struct Opened {
    pub inbox: Arc<Inbox>,
    pub events: Sender<Event>,
    pub waiting: Receiver<Event>,
}

impl Opened {
    pub fn new() -> Self {
        let (events, waiting) = channel();
        Self { inbox: Arc::default(), events, waiting }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_the_page_are_read() {
        let text =
            r#"{"kind":"look","number":3,"scene":"garden","settings":{"views":"9"},"size":[48,32],"moving":true}"#;
        let Ok(PageMessage::Look(look)) = serde_json::from_str(text) else { panic!("no look") };
        assert_eq!((look.number, look.size, look.moving, look.lens), (3, [48, 32], true, None));
        assert_eq!(look.settings["views"], "9");
        assert!(serde_json::from_str::<PageMessage>(r#"{"kind":"read","path":"/etc/passwd"}"#).is_err());
    }

    #[test]
    fn replies_begin_with_the_length_of_their_header() {
        let bytes = Reply::with(serde_json::json!({"kind": "view"}), vec![7, 8]).bytes();
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        assert_eq!(&bytes[4..4 + length], br#"{"kind":"view"}"#);
        assert_eq!(&bytes[4 + length..], [7, 8]);
    }
}
