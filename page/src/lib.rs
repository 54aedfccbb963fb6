//! Page for a browser: an inspector of captures, drawings of moves, and simulated rigs.
//!
//! The page knows no protocol. It sends a request and draws the answer: see [`Page::call`]. The exports for JavaScript are
//! in the module `exports`, which only exists in WebAssembly.

mod curves;
#[cfg(target_arch = "wasm32")]
mod exports;
mod inspect;
mod rig;

use serde::Deserialize;
use serde_json::{Value, json};

pub use rig::Held;

/// State of the page: the rig that it simulates.
#[derive(Default)]
pub struct Page {
    rig: Option<Box<dyn rig::Stage>>,
}

/// Request of the page. It is one line of JSON; bytes of a file may follow the line.
#[derive(Debug, Deserialize)]
#[serde(tag = "call", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// Shows the messages of a capture, which follows.
    Inspect(inspect::Options),
    /// Draws a move, whose file follows.
    Curves { name: String },
    /// Lists protocols and devices.
    Devices,
    /// Switches a rig on, in place of the one before it.
    Start { protocol: String, device: String },
    /// Connects the host to the rig.
    Connect,
    /// Moves a motor by a short way.
    Go { motor: u8 },
    /// Stops everything.
    Stop,
    /// Lets time pass, in milliseconds. `held` is the jog button that is held down.
    Advance { millis: u32, held: Option<Held> },
}

impl Page {
    /// Answers a request with JSON. An error is an object with one member, `error`, which is one line.
    pub fn call(&mut self, request: &[u8]) -> String {
        let (head, body) = match request.iter().position(|byte| *byte == b'\n') {
            Some(at) => (&request[..at], &request[at + 1..]),
            None => (request, &[][..]),
        };
        let answer = serde_json::from_slice(head).map_err(|error| format!("the request: {error}"));
        let answer = answer.and_then(|request| self.answer(request, body));
        answer.unwrap_or_else(|error| json!({ "error": error })).to_string()
    }

    fn answer(&mut self, request: Request, body: &[u8]) -> Result<Value, String> {
        match request {
            Request::Inspect(options) => inspect::inspect(&options, body),
            Request::Curves { name } => curves::curves(&name, body),
            Request::Devices => Ok(rig::devices()),
            Request::Start { protocol, device } => {
                let rig = self.rig.insert(rig::start(&protocol, &device)?);
                Ok(rig.report())
            }
            // A stop comes before everything. It is no error if there is nothing to stop.
            Request::Stop => Ok(self.rig.as_mut().map_or_else(rig::none, |rig| {
                rig.stop();
                rig.report()
            })),
            Request::Advance { millis, held } => self.rig(|rig| rig.advance(millis, held)),
            Request::Connect => self.rig(rig::Stage::connect),
            Request::Go { motor } => self.rig(|rig| rig.go(motor)),
        }
    }

    fn rig(&mut self, act: impl FnOnce(&mut (dyn rig::Stage + 'static))) -> Result<Value, String> {
        let rig = self.rig.as_deref_mut().ok_or("no rig is switched on: start one first")?;
        act(rig);
        Ok(rig.report())
    }
}
