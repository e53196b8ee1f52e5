//! The socket of one page. One thread owns it and waits for what the page sends and for what is to be sent; a second one
//! reads the bytes from the network, a third one draws.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::PoisonError;
use std::sync::mpsc::{Receiver, Sender};

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use crate::protocol::inbox::Inbox;
use crate::protocol::{Event, Opened, PageMessage, Reply};
use crate::render::{Renders, Shared};
use crate::studio::Studio;

/// The largest scene that can be dropped, bytes.
const MAX_SCENE: usize = 1 << 30;

/// The stream that the protocol reads from and writes to: what arrived is in memory, and reading never waits.
struct Pipe {
    arrived: VecDeque<u8>,
    stream: TcpStream,
}

impl Read for Pipe {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.arrived.is_empty() { Err(io::ErrorKind::WouldBlock.into()) } else { self.arrived.read(buffer) }
    }
}

impl Write for Pipe {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.stream.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// Serves a page until it is closed.
pub(crate) fn serve(stream: TcpStream, shared: &Shared) -> io::Result<()> {
    let reader = stream.try_clone()?;
    let ahead = shared.ahead.lock().unwrap_or_else(PoisonError::into_inner).take();
    let is_later = ahead.is_none();
    let Opened { inbox, events, waiting } = ahead.unwrap_or_else(Opened::new);
    let renders = Renders::default();
    std::thread::scope(|scope| {
        let of_reader = events.clone();
        scope.spawn(move || read(reader, &of_reader));
        if is_later {
            let studio = Studio::new(shared.preview, &inbox, events.clone());
            scope.spawn(move || studio.run());
        }
        let pipe = Pipe { arrived: VecDeque::new(), stream };
        let config = WebSocketConfig::default().max_message_size(Some(MAX_SCENE)).max_frame_size(Some(MAX_SCENE));
        let mut socket = WebSocket::from_raw_socket(pipe, Role::Server, Some(config));
        let mut page = Page { inbox: &inbox, shared, events: &events, renders: &renders, dropping: None };
        // The error is that the page is gone, or that it sent what no browser sends.
        let _ = page.serve(&mut socket, &waiting, scope);
        inbox.close();
        renders.stop();
        let _ = socket.get_ref().stream.shutdown(Shutdown::Both);
    });
    Ok(())
}

/// Hands on bytes as they arrive.
fn read(mut stream: TcpStream, events: &Sender<Event>) {
    let mut part = vec![0; 1 << 16];
    loop {
        let count = stream.read(&mut part).unwrap_or(0);
        if events.send(Event::Bytes(part[..count].to_vec())).is_err() || count == 0 {
            return;
        }
    }
}

/// One page that is open.
struct Page<'a> {
    inbox: &'a Inbox,
    shared: &'a Shared<'a>,
    events: &'a Sender<Event>,
    renders: &'a Renders,
    /// The name of the scene whose bytes come next.
    dropping: Option<String>,
}

impl<'a> Page<'a> {
    fn serve<'scope>(
        &mut self,
        socket: &mut WebSocket<Pipe>,
        waiting: &Receiver<Event>,
        scope: &'scope std::thread::Scope<'scope, '_>,
    ) -> Result<(), Box<Error>>
    where
        'a: 'scope,
    {
        let patience = std::time::Duration::from_millis(100);
        loop {
            match waiting.recv_timeout(patience) {
                Ok(Event::Bytes(bytes)) if bytes.is_empty() => return Ok(()),
                Ok(Event::Bytes(bytes)) => {
                    socket.get_mut().arrived.extend(bytes);
                    while let Some(message) = next(socket)? {
                        self.take(message, scope);
                    }
                }
                Ok(Event::Send(reply)) => socket.send(Message::binary(reply.bytes()))?,
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
                Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if self.shared.stop.load(std::sync::atomic::Ordering::SeqCst) {
                let _ = socket.close(None);
                return Ok(());
            }
        }
    }

    fn take<'scope>(&mut self, message: Message, scope: &'scope std::thread::Scope<'scope, '_>)
    where
        'a: 'scope,
    {
        match message {
            Message::Text(text) => match serde_json::from_str(&text) {
                Ok(PageMessage::Look(look)) => self.inbox.look(look),
                Ok(PageMessage::Gallery) => self.inbox.gallery(),
                Ok(PageMessage::Drop { name }) => self.dropping = Some(name),
                Ok(PageMessage::Stop) => self.renders.stop(),
                Ok(PageMessage::Render(look)) => {
                    let (shared, renders, inbox) = (self.shared, self.renders, self.inbox);
                    let events = self.events.clone();
                    scope.spawn(move || renders.run(&look, shared, inbox, &events));
                }
                Err(why) => self.tell(&format!("the page sent what is no message: {why}")),
            },
            Message::Binary(bytes) => match self.dropping.take() {
                Some(name) => self.inbox.drop_scene(holo_core::visible(&name).into_owned(), bytes.to_vec().into()),
                None => self.tell("the page sent bytes without a name"),
            },
            _ => {}
        }
    }

    fn tell(&self, text: &str) {
        // The owner of the socket is this thread.
        let _ = self.events.send(Event::Send(Reply::new(serde_json::json!({"kind": "error", "text": text}))));
    }
}

/// The next whole message that has arrived.
fn next(socket: &mut WebSocket<Pipe>) -> Result<Option<Message>, Box<Error>> {
    match socket.read() {
        Ok(message) => Ok(Some(message)),
        Err(Error::Io(why)) if why.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(why) => Err(Box::new(why)),
    }
}
