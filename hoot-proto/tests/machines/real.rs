//! A master and a node that conducts itself as firmware does: deaf while a start or a change of its address blocks it, hung
//! if two packets wait then, and late with its answers (decisions H-40 and H-41).

use std::collections::VecDeque;

use super::world::*;
use hoot_proto::Address;
use hoot_proto::host::{Command, Event, Failure, Input, Options, Outcome, State, StopState, StopTarget, Token};
use hoot_proto::message::{self, HostMessage, Motor, Reply, ResponseCode};

/// Time for which a start blocks a node, in milliseconds.
const START_BLOCKS: u64 = 1500;
/// Time for which a change of its address blocks a node.
const ADDRESS_BLOCKS: u64 = 2500;
/// Time of a packet on the line.
const FLIGHT: u64 = 2;

/// A master, a node, and the line between them.
struct Real {
    master: Master,
    /// Time by which the answers of the node are late.
    late: u64,
    blocked_until: u64,
    waiting: Vec<HostMessage<'static>>,
    up: VecDeque<(u64, HostMessage<'static>)>,
    down: VecDeque<(u64, Vec<u8>)>,
    runs: bool,
    /// Messages that were sent, with their times.
    sent: Vec<(u64, HostMessage<'static>)>,
    /// Time at which the program of the node was stopped.
    stopped: Option<u64>,
    /// Ends of the commands: data of what was done.
    ended: Vec<(u64, u32, Result<Vec<u8>, Outcome<'static>>)>,
    events: Vec<(u64, Event<'static>)>,
}

impl Real {
    fn new(late: u64) -> Self {
        Self::with(Master::new(Options::default()), late)
    }

    const fn with(master: Master, late: u64) -> Self {
        Self {
            master,
            late,
            blocked_until: 0,
            waiting: Vec::new(),
            up: VecDeque::new(),
            down: VecDeque::new(),
            runs: false,
            sent: Vec::new(),
            stopped: None,
            ended: Vec::new(),
            events: Vec::new(),
        }
    }

    fn input(&mut self, input: Input<'_>) {
        let now = self.master.now;
        let output = self.master.step(input);
        for packet in output.transmits() {
            self.sent.push((now, packet.message));
            self.up.push_back((now + FLIGHT, packet.message));
        }
        for event in output.events() {
            match *event {
                Event::Ended { token: Token(token), outcome: Outcome::Done(reply) } => {
                    self.ended.push((now, token, Ok(reply.data.to_vec())));
                }
                Event::Ended { token: Token(token), outcome } => {
                    self.ended.push((now, token, Err(outcome.to_static().unwrap())));
                }
                event => self.events.extend(event.to_static().map(|event| (now, event))),
            }
        }
    }

    fn request(&mut self, token: u32, message: HostMessage<'static>) {
        self.order(token, Command::Request(hoot_proto::host::Request { to: NODE, message }));
    }

    fn order(&mut self, token: u32, command: Command) {
        self.input(Input::Command(Token(token), command));
    }

    /// The node does what a message says, and answers.
    fn obey(&mut self, message: HostMessage<'static>) {
        let now = self.master.now;
        let mut answer = now;
        let data = match message {
            HostMessage::Start(_) => {
                self.runs = true;
                self.blocked_until = now + START_BLOCKS;
                answer = self.blocked_until;
                vec![]
            }
            HostMessage::SetAddress(_) => {
                self.blocked_until = now + ADDRESS_BLOCKS;
                answer = self.blocked_until;
                vec![]
            }
            HostMessage::Stop(_) => {
                self.runs = false;
                self.stopped.get_or_insert(now);
                vec![]
            }
            HostMessage::MotorRunning(_) => vec![0, self.runs.into()],
            HostMessage::MotorPosition(query) => vec![3, 0, 0, 0, query.motor.get()],
            message if message.query().is_some() => vec![0, 0],
            _ => vec![],
        };
        self.down.push_back((answer + FLIGHT + self.late, data));
    }

    fn arrives(&mut self, message: HostMessage<'static>) {
        if self.master.now >= self.blocked_until {
            return self.obey(message);
        }
        self.waiting.push(message);
        assert!(
            self.waiting.len() < 2,
            "the node hangs: {:?} wait at {}: {:?}",
            self.waiting,
            self.master.now,
            self.sent
        );
    }

    fn pass(&mut self, millis: u64) {
        let end = self.master.now + millis;
        loop {
            let blocked = (!self.waiting.is_empty()).then_some(self.blocked_until);
            let due = |queue: Option<u64>| queue.filter(|due| *due <= end);
            let next = [
                due(blocked),
                due(self.up.front().map(|(due, _)| *due)),
                due(self.down.front().map(|(due, _)| *due)),
                due(self.master.wake.map(|wake| wake.0)),
            ];
            let Some(first) = next.into_iter().flatten().min() else { break };
            self.master.now = first.max(self.master.now);
            match next.map(|due| due == Some(first)) {
                [true, ..] => {
                    let message = self.waiting.remove(0);
                    self.obey(message);
                }
                [_, true, ..] => {
                    let (_, message) = self.up.pop_front().unwrap();
                    self.arrives(message);
                }
                [_, _, true, _] => {
                    let (_, data) = self.down.pop_front().unwrap();
                    self.input(Input::Received(Reply { code: ResponseCode::OK, data: &data }.into()));
                }
                _ => self.input(Input::Wake),
            }
        }
        self.master.now = end;
    }

    /// Messages that were sent in a time.
    fn sent_from(&self, from: u64, until: u64) -> Vec<HostMessage<'static>> {
        self.sent.iter().filter(|(at, _)| (from..until).contains(at)).map(|(_, message)| *message).collect()
    }
}

/// Ways to stop a node, with what confirms the stop.
fn stops() -> [(Command, Event<'static>); 4] {
    let request = |message| Command::Request(hoot_proto::host::Request { to: NODE, message });
    [
        (Command::EmergencyStop, Event::Stopped(StopTarget::All)),
        (request(STOP), Event::Stopped(StopTarget::Node(NODE))),
        (request(PAUSE), Event::Stopped(StopTarget::Node(NODE))),
        (request(motor_stop(Motor::Two)), Event::Stopped(StopTarget::Motor(NODE, Motor::Two))),
    ]
}

// 5-58
#[test]
fn one_stop_waits_at_a_node_that_a_start_blocks() {
    for (stop, confirmation) in stops() {
        for after in (0..2000).step_by(50) {
            let mut real = Real::new(0);
            real.request(1, START);
            let began = real.master.now;
            real.pass(after);
            real.order(2, stop);
            real.pass(20_000);
            let end = began + START_BLOCKS + FLIGHT;
            if after < START_BLOCKS {
                let sent = real.sent_from(began + 1, end);
                assert_eq!(sent, [STOP], "{stop:?} {after} ms after the start");
                assert_eq!(real.stopped, Some(end), "the stop is obeyed at the end of the block");
                assert!(
                    real.sent.iter().any(|(at, message)| *message == STOP && *at <= began + after.max(60)),
                    "at once"
                );
            }
            let told: Vec<_> =
                real.events.iter().map(|(_, event)| *event).filter(|event| *event != Event::Stopping).collect();
            assert_eq!(told, [confirmation], "{stop:?} {after} ms after the start: {:?}", real.sent);
            let (at, _) = real.events.last().unwrap();
            assert!(real.stopped.is_none_or(|stopped| stopped < *at), "not before the node has stopped");
            assert!(*at < began + after.max(START_BLOCKS) + 2500, "{stop:?}, {after}: {at}");
            let of_all = !matches!(confirmation, Event::Stopped(StopTarget::Motor(..)));
            assert!(!of_all || !real.master.machine.may_move(), "{stop:?}");
        }
    }
}

// 5-65
#[test]
fn many_stops_and_keep_alives_are_one_packet_at_a_node_that_may_be_deaf() {
    for pause in [1, 30, 60, 150, 400, 700] {
        let mut real = Real::new(0);
        real.order(1, Command::KeepAlive { to: NODE, on: true });
        real.pass(100);
        real.request(2, START);
        let began = real.master.now;
        for (token, (stop, _)) in (10..).zip(stops().into_iter().rev().cycle().take(12)) {
            real.pass(pause);
            real.order(token, stop);
        }
        real.pass(20_000);
        assert_eq!(real.sent_from(began + 1, began + START_BLOCKS + FLIGHT), [STOP], "every {pause} ms");
        assert_eq!(real.events.last().map(|(_, event)| *event), Some(Event::Stopped(StopTarget::All)));
    }
}

// 5-66
#[test]
fn one_stop_waits_at_a_node_whose_address_changes() {
    for (stop, _) in stops() {
        for after in (0..4000).step_by(100) {
            let mut real = Real::new(0);
            real.request(1, message::SetAddress { new_address: Address(9) }.into());
            let began = real.master.now;
            real.pass(after);
            real.order(2, stop);
            // Another stop, and a request that waits.
            real.pass(100);
            real.request(3, motor_stop(Motor::One));
            real.pass(20_000);
            let sent = real.sent_from(began + 1, began + ADDRESS_BLOCKS + FLIGHT);
            assert!(sent.is_empty() || sent == [STOP], "{stop:?} {after} ms after the change: {sent:?}");
        }
    }
}

// 5-59
#[test]
fn one_stop_waits_at_a_node_that_was_deaf_before_the_line_came_up() {
    for (stop, confirmation) in stops() {
        for before in (0..=START_BLOCKS).step_by(50) {
            // Somebody else has started the program, and did not wait for the answer.
            let mut real = Real::with(Master::offline(Options::default(), &[NODE]), 0);
            real.runs = true;
            real.blocked_until = real.master.now + before;
            real.down.push_back((real.blocked_until + FLIGHT, vec![]));
            let began = real.master.now;
            real.input(Input::LinkUp);
            real.order(1, stop);
            real.pass(150);
            real.request(2, motor_stop(Motor::One));
            real.pass(20_000);
            let wait = real.sent_from(began, real.blocked_until);
            assert!(wait == [STOP] || before == 0, "{stop:?}, deaf for {before}: {wait:?}");
            assert_eq!(real.stopped, Some(real.blocked_until.max(began + FLIGHT)), "{stop:?}, deaf for {before}");
            let confirmed = real.events.iter().find(|(_, event)| *event == confirmation);
            let (at, _) = confirmed.unwrap_or_else(|| panic!("{stop:?}, deaf for {before}: {:?}", real.events));
            assert!(*at > real.blocked_until + FLIGHT, "the answer to the start confirms no stop");
        }
    }
}

// 5-68
#[test]
fn an_answer_that_may_be_that_to_something_else_does_not_say_that_a_node_hears() {
    for (stop, _) in stops() {
        for stray in (10..900).step_by(40) {
            // Somebody else has started the program, and an answer to a packet from before comes late.
            let mut real = Real::with(Master::offline(Options::default(), &[NODE]), 0);
            real.runs = true;
            real.blocked_until = real.master.now + START_BLOCKS;
            real.down.extend([real.master.now + stray, real.blocked_until + FLIGHT].map(|at| (at, vec![])));
            real.input(Input::LinkUp);
            real.order(1, stop);
            real.pass(20_000);
            assert_eq!(real.stopped, Some(real.blocked_until), "{stop:?}, an answer {stray} ms after the line came up");
            assert!(!real.runs);
        }
    }
    // The answer to a new address comes before the node is deaf.
    for (stop, _) in stops() {
        let mut real = Real::new(0);
        real.request(1, message::SetAddress { new_address: Address(9) }.into());
        real.pass(1);
        let began = real.master.now;
        real.pass(60);
        real.down.clear();
        real.down.push_back((real.master.now + 50, vec![]));
        real.order(2, stop);
        real.pass(20_000);
        let sent = real.sent_from(began, began + ADDRESS_BLOCKS);
        assert_eq!(sent, [STOP], "{stop:?}");
    }
}

// 5-60
#[test]
fn after_the_line_came_up_nothing_is_believed_for_a_while() {
    let mut master = Master::offline(Options::default(), &[NODE]);
    master.line_comes_up();
    assert_eq!(master.machine.state(), State::Settling);
    assert!(master.request(1, HostMessage::from(message::MotorPosition { motor: Motor::One })).packets().is_empty());
    assert_eq!(master.request(2, STOP).packets()[0].message, STOP, "a stop waits for nothing");
    for data in [&[][..], &[3, 0, 0, 0, 9]] {
        master.now += 100;
        let output = master.reply(1, data);
        assert!(
            matches!(output.event_list()[..], [Event::Unsolicited(_)]),
            "it may answer a question of somebody else"
        );
    }
    let outputs = master.pass(3000);
    let messages: Vec<_> = sent(&outputs).into_iter().map(|(_, message)| message).collect();
    assert!(messages.contains(&STOP), "only the answer to this one counts");
    // The drain is at least the time to wait and the gap.
    let mut master = Master::offline(Options::default().with_drain(1).with_timeout(2000), &[NODE]);
    master.line_comes_up();
    let _ = master.request(1, HostMessage::from(message::RunStatus {}));
    assert_eq!(sent(&master.pass(2060)).len(), 1);
}

/// Lateness of answers in the reports, in milliseconds.
fn lateness() -> impl Iterator<Item = u64> {
    (0..=1380).step_by(20)
}

// 5-61
#[test]
fn no_question_gets_the_answer_to_another_one() {
    for late in lateness() {
        let mut real = Real::new(late);
        let mut done = 0;
        for token in 0..24 {
            let motor = Motor::ALL[token as usize % 3];
            // Some of the questions have a setting before them, which is not repeated.
            if token % 4 == 0 {
                real.request(100 + token, message::MotorSetEnable { motor, enable: YES }.into());
            }
            real.request(token, message::MotorPosition { motor }.into());
            while !real.ended.iter().any(|(_, ended, _)| *ended == token) {
                real.pass(10);
            }
            match real.ended.iter().find(|(_, ended, _)| *ended == token) {
                Some((_, _, Ok(data))) => {
                    assert_eq!(*data, [3, 0, 0, 0, motor.get()], "{late} ms late");
                    done += 1;
                }
                Some((_, _, Err(outcome))) => {
                    assert_eq!(*outcome, Outcome::Failed(Failure::NoAnswer), "{late} ms late");
                }
                None => panic!("it has ended"),
            }
        }
        assert_eq!(done, 24, "{late} ms late: each question is answered in the time of its repetitions");
    }
}

// 5-62
#[test]
fn a_late_answer_to_a_setting_confirms_no_stop() {
    for late in lateness() {
        for pause in [0, 100, 500, 560, 900, 1300] {
            // The node loses each stop, and only the setting is answered.
            let mut real = Real::new(late);
            real.request(1, message::MotorSetEnable { motor: Motor::One, enable: YES }.into());
            real.pass(pause);
            let at = real.master.now;
            real.up.retain(|(_, message)| !message.conduct().is_stop());
            real.request(2, STOP);
            while real.master.now < at + 1800 {
                real.up.retain(|(_, message)| !message.conduct().is_stop());
                real.pass(1);
            }
            let confirmed = real.events.iter().any(|(_, event)| matches!(event, Event::Stopped(_)));
            assert!(!confirmed, "{late} ms late, {pause}: {:?}", real.events);
            assert!(real.sent.iter().filter(|(_, message)| *message == STOP).count() >= 2, "a lost stop is repeated");
        }
    }
}

// 5-63
#[test]
fn the_same_stop_is_not_repeated_within_the_time_to_wait() {
    for answered in [true, false] {
        for (stop, _) in stops() {
            for before in [None, Some(HostMessage::from(message::MotorSetEnable { motor: Motor::One, enable: YES }))] {
                let mut real = Real::new(0);
                if let Some(message) = before {
                    real.request(1, message);
                }
                real.runs = true;
                for token in 2..30 {
                    if !answered {
                        real.up.clear();
                    }
                    real.order(token, stop);
                    for _ in 0..40 {
                        if !answered {
                            real.up.clear();
                        }
                        real.pass(1);
                    }
                }
                if !answered {
                    for _ in 0..6000 {
                        real.up.clear();
                        real.pass(1);
                    }
                }
                let mut last: Vec<(u64, HostMessage<'static>)> = Vec::new();
                for (at, message) in real.sent.iter().filter(|(_, message)| message.conduct().is_stop()) {
                    let same = last.iter().rev().find(|(_, before)| before == message);
                    let is_early = same.is_some_and(|(before, _)| at - before < 500);
                    assert!(answered || !is_early, "{stop:?}: {message:?} at {at} after {same:?}");
                    last.push((*at, *message));
                }
                assert!(last.len() > 1);
            }
        }
    }
}

// 5-64
#[test]
fn an_emergency_stop_begins_no_round_within_the_time_to_wait() {
    // The motor goes on, whatever the node says.
    let mut real = Real::new(0);
    real.order(1, Command::EmergencyStop);
    for _ in 0..8000 {
        real.runs = true;
        real.pass(1);
    }
    assert_eq!(real.master.machine.stopping().name(), StopState::Stopping.name());
    let stops = |motor| real.sent.iter().filter(move |(_, message)| *message == motor_stop(motor));
    for motor in Motor::ALL {
        let times: Vec<u64> = stops(motor).map(|(at, _)| *at).collect();
        assert!(times.len() > 8, "{times:?}");
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] >= 500), "{times:?}");
    }
    assert!(real.events.contains(&(real.events[1].0, Event::StopNotConfirmed(StopTarget::All))));
}
