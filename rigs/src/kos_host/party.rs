//! What a client is told: of its line, its clock, and by its application.

use kos_proto::host::{self, Endpoint, Input, Token};
use kos_proto::message::Ipv4;
use kos_proto::{DeviceMessage, Frames, Item};
use motion_core::time::Millis;
use tracing::{debug, warn};

use super::{Answer, Command, Content, Device, Event, KosHost, LINE, StoredMove};
use crate::{Host, LineId, Outgoing, Party};

impl Party for KosHost {
    fn open(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.is_open = true;
            self.frames = Some(Box::new(Frames::new()));
            self.step(now, Input::Opened, &Content::default());
        }
    }

    fn close(&mut self, now: Millis, line: LineId) {
        self.advance(now);
        if line == LINE {
            self.is_open = false;
            self.step(now, Input::Closed, &Content::default());
        }
    }

    fn receive(&mut self, now: Millis, line: LineId, bytes: &[u8]) {
        self.advance(now);
        let mut rest = if line == LINE { bytes } else { &[] };
        // The frames are lent by the buffer, which a step must not touch.
        let Some(mut frames) = self.frames.take() else { return };
        while self.is_open && !rest.is_empty() {
            let taken = frames.push(rest);
            rest = rest.get(taken..).unwrap_or_default();
            while let Some(item) = frames.next() {
                self.item(now, &item);
                if !self.is_open {
                    break;
                }
            }
            if taken == 0 {
                break;
            }
        }
        self.frames = Some(frames);
    }

    fn advance(&mut self, now: Millis) {
        while let Some(due) = self.wake.filter(|due| *due <= now) {
            self.step(due, Input::Wake, &Content::default());
        }
    }

    fn wake(&self) -> Option<Millis> {
        self.wake
    }

    fn poll(&mut self) -> Option<Outgoing> {
        self.outgoing.pop_front()
    }
}

impl Host for KosHost {
    type Command = Command;
    type Event = Event;

    fn command(&mut self, now: Millis, command: Command) {
        self.advance(now);
        let plain = Content::default();
        match command {
            // Where it is, knows who opens the line.
            Command::Connect => self.order(now, host::Command::Connect(Endpoint::Tcp(Ipv4::default())), &plain),
            Command::Unlock(password) => {
                self.password = password;
                self.order(now, host::Command::Unlock, &plain);
            }
            Command::ChangePassword(password) => {
                let content = Content { new_password: &password, ..plain };
                if !self.step(now, Input::Command(host::Command::ChangePassword), &content) {
                    self.password = password;
                }
            }
            Command::Ask(get) => {
                self.token = self.token.wrapping_add(1);
                self.order(now, host::Command::Get(get, Token(self.token)), &plain);
            }
            Command::Load { stored, way, delay_return } => {
                let command = host::Command::Load { summary: *stored.summary(), way, delay_return };
                self.order(now, command, &Content { stored: Some(&stored), ..plain });
            }
            Command::PlayDirect { stored, way } => {
                let command = host::Command::PlayDirect { summary: *stored.summary(), way };
                self.order(now, command, &Content { stored: Some(&stored), ..plain });
            }
            Command::Do(command) => self.order(now, command, &plain),
        }
    }

    fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}

impl KosHost {
    fn item(&mut self, now: Millis, item: &Item<'_, kos_proto::Frame<'_>, kos_proto::Header>) {
        match item {
            Item::Frame(frame) => match DeviceMessage::decode(frame) {
                Ok(message) => {
                    debug!("hears {message}");
                    let content = Content { message: Some(&message), ..Content::default() };
                    self.step(now, Input::Received(message), &content);
                }
                Err(error) => {
                    let (id, kind) = (frame.id(), frame.kind());
                    self.step(now, Input::Malformed { id, kind, error }, &Content::default());
                }
            },
            Item::Fatal(why) => {
                warn!("what the device sends is no stream of messages: {why}");
                self.step(now, Input::Fatal, &Content::default());
            }
            Item::Noise { bytes, why } => warn!("{} bytes are left out: {why}", bytes.len()),
            Item::Corrupt { why, .. } => warn!("{why}"),
        }
    }
}

/// What a message answers; the motors are what all messages of a series say together, and known to the machine.
pub(super) fn answer(message: &DeviceMessage<'_>) -> Option<Answer> {
    Some(match message {
        DeviceMessage::DeviceInfo(info) => Answer::Device(Device {
            device_type: info.device_type,
            firmware: info.firmware_version,
            mode: info.playback_mode,
            state: info.playback_status,
            inputs: info.aux_input_status,
            remaining: info.delay_time_remaining,
            elapsed: info.elapsed_time,
        }),
        DeviceMessage::NetworkInfo(info) => {
            let kos_proto::message::NetworkInfo {
                dhcp,
                mac_address,
                ip_address,
                subnet_mask,
                gateway,
                device_type,
                device_addr,
                tail: _,
            } = *info;
            let tail = &[];
            Answer::Network(kos_proto::message::NetworkInfo {
                dhcp,
                mac_address,
                ip_address,
                subnet_mask,
                gateway,
                device_type,
                device_addr,
                tail,
            })
        }
        DeviceMessage::LEDStatus(leds) => Answer::Lamps(leds.master_status, leds.slave_status),
        DeviceMessage::TrajectoryData(data) => Answer::Move(StoredMove::new(data).ok()),
        DeviceMessage::DeviceGUID(guid) => Answer::Guid(guid.guid.0.to_vec()),
        DeviceMessage::SoftwareID(software) => Answer::Platform(software.platform),
        _ => return None,
    })
}
