//! A move on three simulated rigs, on a virtual clock.

use std::collections::BTreeSet;

use dmc_proto::Token as DmcToken;
use dmc_proto::host::Event as DmcTold;
use dmc_proto::message::{Milliseconds, Motor as DmcMotor, RtRunMove, RunFlags};
use dmc_proto::upload::MoveSource;
use hoot_proto::host::{Command as ToNode, Options as MasterOptions, Request, Token as HootToken};
use hoot_proto::message::{
    self as hoot_message, CameraSetEnable, MotorSendToStart, MotorSetContinuousAcceleration, MotorSetContinuousSpeed,
    MotorSetEnable, ProgramMode, SetProgramMode, StepsPerSecond, StepsPerSecondSquared,
};
use hoot_proto::{Address, HostMessage as HootMessage};
use kos_proto::host::{self as kos_host, Go, Outcome, Token as KosToken};
use kos_proto::message::{AxisKind, MotorAddress, Rotations, RotationsPerSecond, RotationsPerSecondSquared};
use motion_core::trajectory::Range;
use motion_move::Move;
use motion_rigs::dmc_device::{self, DmcDevice};
use motion_rigs::dmc_host::{self, DmcHost, Table};
use motion_rigs::faults::{Carrier, Faults};
use motion_rigs::hoot_master::{self, HootMaster};
use motion_rigs::hoot_node::{self, HootNode};
use motion_rigs::kos_device::{self, KosDevice, MotorSetup};
use motion_rigs::kos_host::{Command, Event, KosHost, StoredMove};
use motion_rigs::motor::Motor;
use motion_rigs::{Host, Rig, Scene};
use plot::Played;

use super::Converted;

/// Time that a rig may take for one step of the work, in milliseconds of its clock.
const PATIENCE: u64 = 1_800_000;
/// Time before and after a run in which DMC motors gain and lose speed, in milliseconds.
const ROLL: u32 = 500;
/// Travel of a simulated motor: further than any move.
const ANYWHERE: Range = Range::new(-4e9, 4e9);

type Tracks = Result<Vec<Played>, String>;

/// Where the motors of each rig that the move is converted for went.
pub(super) fn all(subject: &Move, converted: &Converted<'_>) -> Vec<(&'static str, Tracks)> {
    let mut played = Vec::new();
    if let Ok(converted) = &converted.kos {
        played.push(("kOS", kos(subject, converted)));
    }
    if let Ok(converted) = &converted.dmc {
        played.push(("DMC", dmc(subject, converted)));
    }
    if let Ok(converted) = &converted.hoot {
        let nodes: BTreeSet<Address> = converted.planned.iter().map(|planned| planned.node).collect();
        played.extend(nodes.into_iter().map(|node| ("hoot", hoot(subject, converted, node))));
    }
    played
}

/// Runs a scene until an event.
fn wait<H: Host, R: Rig, T>(
    scene: &mut Scene<H, R>,
    what: &str,
    mut look: impl FnMut(H::Event) -> Option<T>,
) -> Result<T, String> {
    let until = scene.now().after(PATIENCE);
    scene.run(until, |_, event| look(event)).ok_or_else(|| format!("it does not say {what}"))
}

/// Runs a scene until all motors rest.
fn rest<H: Host, R: Rig>(scene: &mut Scene<H, R>) {
    for _ in 0..PATIENCE {
        scene.run(scene.now().after(1), |_, _| None::<()>);
        if scene.rig.motors().iter().all(Motor::rests) {
            return;
        }
    }
}

/// A motor of an axis: the number of the axis, that of the motor from 0, and the position of the axis for one of the motor.
type Follow<'a> = (usize, usize, Box<dyn Fn(f64) -> f64 + 'a>);

/// Follows the motors while a move is played. `seconds` is the time of the move at a moment of the rig.
fn follow<H: Host, R: Rig>(
    scene: &mut Scene<H, R>,
    label: &'static str,
    seconds: impl Fn(f64) -> f64,
    motors: &[Follow<'_>],
) -> Tracks {
    let mut tracks: Vec<Played> =
        motors.iter().map(|(axis, ..)| Played { label, axis: *axis, places: Vec::new() }).collect();
    for _ in 0..PATIENCE {
        scene.run(scene.now().after(1), |_, _| None::<()>);
        let now = scene.now();
        match scene.rig.moment() {
            Some(moment) => {
                for ((_, motor, position), track) in motors.iter().zip(&mut tracks) {
                    let place = scene.rig.motors().get(*motor).map(|motor| motor.at(now).position);
                    track.places.extend(place.map(|place| (seconds(moment), position(place))));
                }
            }
            None if tracks.iter().any(|track| !track.places.is_empty()) => return Ok(tracks),
            None => {}
        }
    }
    Err("the move does not end".to_owned())
}

fn kos(subject: &Move, converted: &motion_move::kos::Converted<'_>) -> Tracks {
    let axes = subject.axes().iter().enumerate().filter_map(|(index, axis)| Some((index, axis.kos()?)));
    let axes: Vec<_> = axes.collect();
    let count = axes.iter().map(|(_, kos)| usize::from(kos.motor)).max().unwrap_or(1);
    let motors = vec![MotorSetup::new(AxisKind::Slider); count];
    let rig = KosDevice::new(kos_device::Setup { motors, ..kos_device::Setup::default() });
    let host = KosHost::new(kos_host::Options::default(), None);
    let mut scene = Scene::new(host, rig, Carrier::Stream, Faults::NONE, 1);
    let mut last = 0;
    let mut give = |scene: &mut Scene<_, _>, command| {
        last += 1;
        scene.command((KosToken(last), command));
        KosToken(last)
    };
    let done = |scene: &mut Scene<KosHost, KosDevice>, token: KosToken| {
        let outcome = wait(scene, "that a command is done", |event| match event {
            Event::Machine(kos_host::Event::Ended { token: ended, outcome }) if ended == token => Some(outcome),
            _ => None,
        })?;
        if matches!(outcome, Outcome::Done(_)) { Ok(()) } else { Err(outcome.to_string()) }
    };
    let told = |event: Event, wanted: fn(&kos_host::Event<'_>) -> bool| match event {
        Event::Machine(event) if wanted(&event) => Some(()),
        _ => None,
    };
    give(&mut scene, Command::Connect);
    wait(&mut scene, "that it is ready", |event| told(event, |event| matches!(event, kos_host::Event::Ready { .. })))?;
    for (_, kos) in &axes {
        let motor = MotorAddress(kos.motor);
        let machine = Command::Machine;
        give(&mut scene, machine(kos_host::Command::ResetAxis(motor)));
        wait(&mut scene, "its motors", |event| told(event, |event| *event == kos_host::Event::Motors))?;
        give(&mut scene, machine(kos_host::Command::MarkBegin(motor)));
        #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
        let position = Rotations(kos.range.width() as f32);
        let (speed, acceleration) = (RotationsPerSecond(10.0), RotationsPerSecondSquared(20.0));
        let token = give(&mut scene, machine(kos_host::Command::Bump(Go { motor, position, speed, acceleration })));
        done(&mut scene, token)?;
        let token = give(&mut scene, machine(kos_host::Command::MarkEnd(motor)));
        done(&mut scene, token)?;
    }
    let stored = StoredMove::new(&converted.data()).map_err(|error| error.to_string())?;
    let token = give(&mut scene, Command::Load { stored, delay_return: false });
    done(&mut scene, token)?;
    give(&mut scene, Command::Machine(kos_host::Command::Play));
    let motors: Vec<Follow<'_>> = axes
        .into_iter()
        .map(|(index, kos)| {
            // The range begins where the motor was at first.
            let position = move |at: f64| (at + kos.range.from - kos.rotations.offset) / kos.rotations.per_unit;
            (index, usize::from(kos.motor) - 1, Box::new(position) as Box<dyn Fn(f64) -> f64>)
        })
        .collect();
    follow(&mut scene, "kOS", |seconds| seconds, &motors)
}

fn dmc(subject: &Move, converted: &motion_move::dmc::Converted<'_>) -> Tracks {
    let axes = subject.axes().iter().enumerate().filter_map(|(index, axis)| Some((index, axis.dmc()?)));
    let axes: Vec<_> = axes.collect();
    let count = axes.iter().map(|(_, dmc)| dmc.motor).max().unwrap_or(1);
    let frames = converted.frame_count();
    let mut setup = dmc_device::Setup::with_motors(count).with_frames(frames.max(dmc_device::Setup::FRAMES));
    for motor in &mut setup.motors {
        *motor = motor.clone().within(ANYWHERE);
    }
    let mut scene = Scene::new(DmcHost::default(), DmcDevice::new(setup), Carrier::Serial, Faults::NONE, 1);
    let ready = |event| matches!(event, dmc_host::Event::Machine(DmcTold::Ready { .. })).then_some(());
    wait(&mut scene, "that it is ready", ready)?;
    let mut table = Table::new(converted.start_frame(), frames);
    for motor in converted.motors().iter() {
        table = table.with(motor, (0..frames).map(|index| converted.position(motor, index).0).collect());
    }
    let end_frame = table.last_frame();
    let (upload, run) = (DmcToken(1), DmcToken(2));
    scene.command(dmc_host::Command::Upload(upload, table));
    let end = |token| {
        move |event| match event {
            dmc_host::Event::Ended(ended, end) if ended == token => Some(end),
            _ => None,
        }
    };
    wait(&mut scene, "that it has the move", end(upload))?.map_err(|outcome| outcome.to_string())?;
    let message = RtRunMove {
        fps_x1000: converted.rate(),
        start_frame: converted.start_frame(),
        end_frame,
        pre_roll_ms: Milliseconds(ROLL),
        post_roll_ms: Milliseconds(ROLL),
        flags: Some(RunFlags::empty()),
        ..RtRunMove::default()
    };
    scene.command(dmc_host::Command::Begin(run, message.into()));
    let armed = wait(&mut scene, "that it is armed", |event| match event {
        dmc_host::Event::Machine(DmcTold::Armed(_)) => Some(Ok(())),
        dmc_host::Event::Ended(ended, Err(outcome)) if ended == run => Some(Err(outcome.to_string())),
        _ => None,
    })?;
    armed?;
    scene.command(dmc_host::Command::Go);
    let motors: Vec<Follow<'_>> = axes
        .into_iter()
        .map(|(index, dmc)| {
            let position = move |at: f64| (at - dmc.scale.offset()) / dmc.scale.per_unit();
            let motor = usize::from(DmcMotor(dmc.motor).0) - 1;
            (index, motor, Box::new(position) as Box<dyn Fn(f64) -> f64>)
        })
        .collect();
    let frame = subject.frames().rate.seconds(1);
    follow(&mut scene, "DMC", |moment| (moment - 1.0) * frame, &motors)
}

fn hoot(subject: &Move, converted: &motion_move::hoot::Converted<'_>, node: Address) -> Tracks {
    let options = hoot_proto::device::Options::default().with_address(node);
    let rig = HootNode::new(hoot_node::Setup::default().with_options(options).with_travel(ANYWHERE));
    let mut scene = Scene::new(HootMaster::new(MasterOptions::new()), rig, Carrier::Serial, Faults::NONE, 1);
    let ready = |event| match event {
        hoot_master::Event::Machine(hoot_proto::host::Event::Ready { .. }) => Some(()),
        _ => None,
    };
    wait(&mut scene, "that it is ready", ready)?;
    let mut last = 0;
    let mut ask = |scene: &mut Scene<HootMaster, HootNode>, message: HootMessage<'static>| {
        last += 1;
        scene.command((HootToken(last), ToNode::Request(Request { to: node, message })));
        let ended = wait(scene, "that a command is done", |event| match event {
            hoot_master::Event::Ended(ended) if ended.token == HootToken(last) => Some(ended),
            _ => None,
        })?;
        if ended.is_done() { Ok(()) } else { Err(ended.to_string()) }
    };
    ask(&mut scene, SetProgramMode { program_mode: ProgramMode::VIDEO }.into())?;
    ask(&mut scene, CameraSetEnable { enable: false.into() }.into())?;
    let ours: Vec<_> = converted.planned.iter().filter(|planned| planned.node == node).collect();
    for planned in &ours {
        let motor = planned.motor;
        let (speed, acceleration) = (StepsPerSecond(4000.0), StepsPerSecondSquared(5000.0));
        ask(&mut scene, MotorSetEnable { motor, enable: true.into() }.into())?;
        ask(&mut scene, MotorSetContinuousAcceleration { motor, acceleration }.into())?;
        ask(&mut scene, MotorSetContinuousSpeed { motor, speed }.into())?;
        for message in planned.messages(false).map_err(|error| error.to_string())? {
            ask(&mut scene, message)?;
        }
        ask(&mut scene, MotorSendToStart { motor }.into())?;
        rest(&mut scene);
    }
    ask(&mut scene, hoot_message::Start {}.into())?;
    let motors: Vec<Follow<'_>> = subject
        .axes()
        .iter()
        .enumerate()
        .filter_map(|(index, axis)| Some((index, axis.hoot().filter(|hoot| hoot.address == node.0)?)))
        .map(|(index, hoot)| {
            let position = move |at: f64| (at - hoot.scale.offset()) / hoot.scale.per_unit();
            (index, usize::from(hoot.motor) - 1, Box::new(position) as Box<dyn Fn(f64) -> f64>)
        })
        .collect();
    follow(&mut scene, "hoot", |moment| moment / 1000.0, &motors)
}
