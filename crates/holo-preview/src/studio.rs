//! The studio: draws what the page looks at. It keeps the scene and its world as long as they stay the same, and the
//! acceleration structure as long as the camera stands still.

use std::sync::mpsc::Sender;

use holo_dataset::{About, RenderJob, SceneSettings, SceneSource, Sky};
use holo_scene::{Transform, gallery};
use serde_json::json;

use crate::Preview;
use crate::draw;
use crate::draw::{Drawing, Kept};
use crate::job::{self, Ended};
use crate::protocol::inbox::{Inbox, Newest, Task};
use crate::protocol::{Event, Look, Reply};

/// Width and height of the images of the gallery, px.
const THUMBNAIL: [usize; 2] = [180, 120];

/// What a world depends on.
#[derive(PartialEq)]
struct WorldKey {
    scene: String,
    settings: SceneSettings,
    sky: Sky,
}

impl WorldKey {
    fn new(scene: &str, job: &RenderJob) -> Self {
        let mut settings = job::at_first_frame(job.clone()).settings.scene;
        // Where the camera stands.
        (settings.camera, settings.eye, settings.target, settings.up) = (None, None, None, None);
        (settings.fov_deg, settings.fit_object) = (None, None);
        Self { scene: scene.to_owned(), settings, sky: job.settings.light.sky.clone() }
    }
}

pub(crate) struct Studio<'a> {
    preview: &'a Preview,
    inbox: &'a Inbox,
    events: Sender<Event>,
    /// The last scene with its key: making one of the gallery takes time.
    source: Option<(SceneSource, String)>,
    /// How many scenes of the gallery the page shows.
    thumbnails: usize,
}

impl<'a> Studio<'a> {
    pub fn new(preview: &'a Preview, inbox: &'a Inbox, events: Sender<Event>) -> Self {
        Self { preview, inbox, events, source: None, thumbnails: 0 }
    }

    /// Draws until the page is gone.
    pub fn run(mut self) {
        self.send(Reply::new(self.hello()));
        self.draw_all();
    }

    /// Draws for a page that is not open yet: the scene that it begins with is loaded before its first look arrives.
    pub fn run_ahead(mut self) {
        self.send(Reply::new(self.hello()));
        // The page asks for it again, and is told then what is wrong with it.
        let _ = self.show(None);
        self.draw_all();
    }

    fn draw_all(&mut self) {
        while let Some((task, newest)) = self.inbox.next() {
            match task {
                Task::Gallery => self.gallery(newest),
                Task::Look(look) => {
                    let number = look.number;
                    if let Err(Ended::Failed(why)) = self.show(Some((look, newest))) {
                        self.tell(number, &why);
                    }
                }
            }
        }
    }

    /// What a page has to know before it shows anything.
    fn hello(&self) -> serde_json::Value {
        let Preview { scene, camera, poses, given, out, .. } = self.preview;
        let scenes: Vec<_> = gallery::all_names()
            .map(|name| json!({"name": name, "purpose": gallery::purpose(name).unwrap_or_default()}))
            .collect();
        let cameras: Vec<_> = holo_core::plenoptic::presets()
            .iter()
            .map(|preset| json!({"name": preset.name, "description": preset.description}))
            .collect();
        let given: serde_json::Map<_, _> = given.iter().map(|(key, text)| (key.to_owned(), json!(text))).collect();
        json!({
            "kind": "hello",
            "version": env!("CARGO_PKG_VERSION"),
            "scene": scene.as_ref().map(|scene| holo_core::visible(&scene.name()).into_owned()),
            "camera": camera.as_ref().map(|camera| holo_core::visible(&camera.name).into_owned()),
            "given": given,
            "renders": out.is_some(),
            "gallery": scenes,
            "cameras": cameras,
            "poses": poses.iter().flat_map(|poses| &poses.cameras).map(job::offered).collect::<Vec<_>>(),
        })
    }

    /// Loads the scene of the first look, or that which a page begins with, and shows looks at it until one is of another
    /// scene.
    fn show(&mut self, first: Option<(Look, Newest)>) -> Result<(), Ended> {
        let (job, key) = match &first {
            Some((look, _)) => self.job(look)?,
            None => self.job(&job::first_look(self.preview))?,
        };
        let notes = std::cell::RefCell::new(Vec::new());
        let note = |_: About, line: &str| notes.borrow_mut().push(job::told(line));
        let stage = job::at_first_frame(job.clone()).stage(&note)?;
        let world = stage.world(&job.source, &job.settings.light.sky, &job.engine)?;
        let still = world.at(&Transform::IDENTITY)?;
        let (scene, animations) = (&stage.loaded.scene, &stage.loaded.summary.animations);
        let seconds = animations.iter().map(|animation| animation.seconds).fold(0.0, f64::max);
        let frames_per_second = job.settings.scene.frames_per_second();
        self.send(Reply::new(json!({
            "kind": "scene",
            "name": holo_core::visible(&job.source.name()),
            "triangles": scene.triangle_count(),
            "cameras": scene.cameras.iter().map(|camera| holo_core::visible(&camera.name)).collect::<Vec<_>>(),
            "frames": (seconds > 0.0).then(|| (seconds * frames_per_second) as u64 + 1),
            "bounds": scene.bounds().map(|(low, high)| [low, high]),
            "notes": notes.take(),
        })));
        let mut kept = Kept::default();
        let mut next = first.map(|(look, newest)| (look, job, newest));
        loop {
            if let Some((look, job, newest)) = next.take() {
                let shown = job::at_first_frame(job.clone());
                let drawing = Drawing {
                    stage: &stage,
                    world: &world,
                    still: &still,
                    job: &shown,
                    look: &look,
                    frames: job.shots().len(),
                    newest,
                    events: &self.events,
                };
                if let Err(Ended::Failed(why)) = drawing.draw(&mut kept) {
                    self.tell(look.number, &why);
                }
            }
            while next.is_none() {
                let Some((task, later)) = self.inbox.next() else { return Ok(()) };
                let Task::Look(look) = task else {
                    self.gallery(later);
                    continue;
                };
                match self.job(&look) {
                    Ok((_, other)) if other != key => {
                        self.inbox.put_back(look);
                        return Ok(());
                    }
                    Ok((job, _)) => next = Some((look, job, later)),
                    Err(Ended::Failed(why)) => self.tell(look.number, &why),
                    Err(Ended::Newer) => {}
                }
            }
        }
    }

    /// The job of a look, and the key of its world.
    fn job(&mut self, look: &Look) -> Result<(RenderJob, WorldKey), Ended> {
        let is_kept = self.source.as_ref().is_some_and(|(_, key)| !look.scene.is_empty() && *key == look.scene);
        if !is_kept {
            self.source = Some(job::scene(look, self.preview, self.inbox)?);
        }
        let Some((source, scene)) = &self.source else { return Err(Ended::Newer) };
        let job = job::of(look, source.clone(), self.preview)?;
        let key = WorldKey::new(scene, &job);
        Ok((job, key))
    }

    /// Draws the scenes of the gallery, small; the page shows each as it comes. Looks go first.
    fn gallery(&mut self, newest: Newest) {
        for name in gallery::all_names().skip(self.thumbnails) {
            let look = Look { scene: name.to_owned(), size: THUMBNAIL, ..Look::default() };
            let drawn = job::scene(&look, self.preview, self.inbox)
                .and_then(|(source, _)| job::of(&look, source, self.preview))
                .map_err(Ended::from)
                .and_then(|job| draw::thumbnail(&job, THUMBNAIL, newest));
            match drawn {
                Ok(image) => self.send(Reply::with(json!({"kind": "thumbnail", "name": name}), image)),
                Err(Ended::Failed(why)) => self.tell(0, &why),
                Err(Ended::Newer) => return self.inbox.put_gallery_back(),
            }
            self.thumbnails += 1;
        }
    }

    fn send(&self, reply: Reply) {
        // The page may be gone; the inbox says so next.
        let _ = self.events.send(Event::Send(reply));
    }

    fn tell(&self, number: u64, text: &str) {
        self.send(Reply::new(json!({"kind": "error", "number": number, "text": text})));
    }
}
