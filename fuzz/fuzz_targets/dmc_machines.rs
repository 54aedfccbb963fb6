//! DMC: any inputs of a host and a device, alone and with each other on a faulty line, in any order.
//!
//! Input: the window, and whether motors have to be enabled; the quirks; then steps; see `fuzz::machines`.

#![no_main]

use dmc_proto::device::{self, DeviceMachine, Event as AtRig, Quirks, StopKind, Store};
use dmc_proto::host::{self, Command, Contents, HostMachine, StopTarget, Transmit};
use dmc_proto::message::{AckCode, FrameNumber, Motor, Motors, Triggers, VirtualMotor};
use dmc_proto::upload::{Section, SectionSize};
use dmc_proto::{DecodeError, Device, Effect, Frame, Host, HostMessage, MessageId, MessageType};
use fuzz::fuzz_world;
use fuzz::machines::{Bytes, World, arrival, print, send, step, world};

#[path = "../../dmc-proto/tests/machines/app.rs"]
mod app;

use app::{App, Tens, answer, hi, may_not_stop, the_rig_acts_first};

fuzz_world!(Dmc);

struct Dmc<'i> {
    world: World<HostMachine, DeviceMachine>,
    app: App<'i>,
    /// Message that the device stored last.
    store: Option<Store>,
}

impl<'i> Dmc<'i> {
    fn new(bytes: &mut Bytes<'i>) -> Self {
        let first = bytes.byte();
        let options = host::Options::default().with_window(first % 128).with_needs_enabled(first >= 128);
        let host = HostMachine::new(options);
        let quirks = Quirks(u32::from_le_bytes(bytes.few()));
        let device = DeviceMachine::new(device::Options::of(hi()).with_quirks(quirks));
        Self { world: world(host, device), app: App::default(), store: None }
    }

    fn act(&mut self, bytes: &mut Bytes<'i>) {
        match bytes.byte() % 16 {
            0..4 => {
                if let Some(frame) = arrival(&mut self.world.up, bytes) {
                    let rig = if bytes.byte() == 1 { AckCode::ERR_SOFT_UP } else { AckCode::OK };
                    let header = [2, 6].map(|at| frame[at..].first_chunk().copied().unwrap_or_default());
                    let id = MessageId(u32::from_le_bytes(header[0]));
                    let kind = MessageType(u16::from_le_bytes([header[1][0], header[1][1]]));
                    self.tell_device(match Frame::decode(&frame) {
                        Ok(frame) => device::Input::received(&frame, |_| rig),
                        Err(_) => device::Input::Corrupt(id, kind),
                    });
                }
            }
            4..8 => {
                if let Some(frame) = arrival(&mut self.world.down, bytes) {
                    self.tell_host(match Frame::decode(&frame) {
                        Ok(frame) => host::Input::received(&frame),
                        Err(_) => host::Input::Corrupt,
                    });
                }
            }
            8 => {
                let id = MessageId(bytes.byte().into());
                let drawn = bytes.message::<Host>();
                let input = match drawn.read() {
                    Ok(message) => device::Input::Received { id, message, rig: AckCode::OK },
                    Err((number, error)) => device::Input::Malformed(id, kind_of(number, error)),
                };
                self.tell_device(input);
            }
            9 => {
                let id = self.id(bytes);
                let drawn = bytes.message::<Device>();
                let input = match drawn.read() {
                    Ok(message) => host::Input::Received(id, message),
                    Err((number, error)) => host::Input::Malformed(id, kind_of(number, error)),
                };
                self.tell_host(input);
            }
            10 | 11 => {
                let input = self.report(bytes);
                self.tell_device(input);
            }
            12 => self.tell_device(device::Input::Wake),
            13 => {
                let input = match bytes.byte() % 8 {
                    0 => host::Input::LinkDown,
                    1 => host::Input::Section(Section::first(&Tens, SectionSize::default())),
                    2 => host::Input::Section(None),
                    3 => host::Input::LinkUp,
                    _ => host::Input::Wake,
                };
                self.tell_host(input);
            }
            _ => self.command(bytes),
        }
    }

    /// Id of a request under way, or any small id.
    fn id(&self, bytes: &mut Bytes<'_>) -> MessageId {
        let choice = bytes.byte();
        let pending = self.world.host.machine.pending().nth(choice.into());
        pending.map_or(MessageId(choice.into()), |(id, _)| id)
    }

    fn report(&self, bytes: &mut Bytes<'_>) -> device::Input<'static> {
        let (what, which) = (bytes.byte(), bytes.byte());
        let motor = Motor(which % 10);
        match what % 16 {
            0 => device::Input::LinkUp,
            1 => device::Input::LinkDown,
            2 => device::Input::Rig(device::Report::Moving(Motors(which.into()))),
            3..7 => device::Input::Rig(device::Report::AtRest),
            7 => device::Input::Rig(device::Report::AtFrame(FrameNumber(which.into()))),
            8 => device::Input::Rig(device::Report::PassEnd),
            9 => device::Input::Rig(device::Report::OperatorGo),
            10 => device::Input::Rig(device::Report::Limit { motor, upper: which > 100 }),
            11 => device::Input::Rig(device::Report::EmergencyStop(which > 100)),
            12 => device::Input::Rig(device::Report::Fault(Some(motor))),
            13 => device::Input::Rig(device::Report::Inputs(Triggers(which.into()))),
            14 => device::Input::Rig(device::Report::Aimed),
            // The buffer answers the last message once more.
            _ => self.store.map_or(device::Input::Wake, |store| {
                device::Input::Rig(device::Report::Stored(store, AckCode(which.into())))
            }),
        }
    }

    fn command(&mut self, bytes: &mut Bytes<'i>) {
        let command = match bytes.byte() % 16 {
            0 => Command::Greet,
            1 => Command::Configured,
            2 | 3 => Command::Go,
            4 => Command::EndStops,
            5 => Command::Stop(StopTarget::Motor(Motor(bytes.byte()))),
            6 => Command::Stop(StopTarget::Virtual(VirtualMotor(bytes.byte()))),
            7 => Command::Stop(if bytes.flag() { StopTarget::AllSilent } else { StopTarget::All }),
            what => {
                let Some(message) = bytes.borrowed() else { return };
                if what < 12 { Command::Request(message) } else { Command::Sequence(message) }
            }
        };
        let input = self.app.command(command);
        self.tell_host(input);
    }

    fn tell_host(&mut self, input: host::Input<'_>) {
        let is_online = self.world.host.machine.state() != host::State::Offline;
        let output = step(&mut self.world.host, self.world.now, input, host::Input::Wake);
        if let host::Input::Command(_, Command::Stop(_)) = input {
            let is_stop = |effect: &_| matches!(effect, Effect::Transmit(Transmit { contents: Contents::Stop(_), .. }));
            assert_eq!(output.effects.first().is_some_and(is_stop), is_online, "a stop is sent first: {output:?}");
        }
        self.app.takes(&output, &self.world.host.machine);
        for transmit in output.transmits() {
            send(&mut self.world.up, self.world.now, &self.app.frame(transmit));
        }
        if let Some(section) = self.app.section(&output) {
            self.tell_host(section);
        }
    }

    fn tell_device(&mut self, input: device::Input<'_>) {
        let has_to_stop = match &input {
            device::Input::Received { message: message @ HostMessage::MotorStopAll(_), .. } => {
                !may_not_stop(&self.world.device.machine, message)
            }
            _ => false,
        };
        let output = step(&mut self.world.device, self.world.now, input, device::Input::Wake);
        the_rig_acts_first(&output);
        if has_to_stop {
            let is_obeyed = matches!(
                output.effects.first(),
                Some(Effect::Event(AtRig::Stop(StopKind::All { .. } | StopKind::Harder | StopKind::Hard)))
            );
            assert!(is_obeyed, "a stop is obeyed first: {output:?}");
        }
        for effect in output {
            match effect {
                Effect::Transmit(transmit) => send(&mut self.world.down, self.world.now, &answer(&transmit)),
                Effect::Event(AtRig::Store { store, .. }) => {
                    self.store = Some(store);
                    self.tell_device(device::Input::Rig(device::Report::Stored(store, AckCode::OK)));
                }
                Effect::Event(_) => {}
            }
        }
    }
}

/// Type of a message that is too short, from its number in the tables.
fn kind_of(number: u32, error: DecodeError) -> MessageType {
    print(&error);
    MessageType(u16::try_from(number).unwrap_or_default())
}
