//! Work of a host: what the session says and what the application wants, with the messages and the move that the session does not
//! keep.

use dmc_proto::host::{self, Failure, Next, NotTaken, Outcome, Refusal, Session, StopTarget};
use dmc_proto::message::{AckCode, GioCam, HostMessage, MotorConfigure, MotorGetPosition, MotorStatusRequest};
use dmc_proto::{EncodeError, Frame, Owned, Token};
use tracing::{Level, debug, enabled, info, warn};

use super::check::Check;
use super::uses::{Waiting, lacking};
use super::{Answer, Command, DmcHost, Event, LINE, STORE};
use crate::Outgoing;

/// Least of the tokens that the host uses for its own commands.
const FIRST_OWN: Token = Token(u32::MAX - 4);
/// Token of commands that the application gives without a token, and of the end of the configuration.
const OWN: Token = FIRST_OWN;
/// Token of the request that sets the uses of a motor before a command moves it.
const USES: Token = Token(u32::MAX - 3);
/// Token of the request that closes the shutter.
const SHUTTER: Token = Token(u32::MAX - 2);
/// Token of the question for positions at the end of a way.
const CHECK: Token = Token(u32::MAX - 1);
/// Token of the question whether motors still move after a stop.
const REST: Token = Token(u32::MAX);

/// End of a request that the device does not know.
const UNSUPPORTED: Outcome<'static> = Outcome::Refused(Refusal::Device(AckCode::ERR_UNSUPPORTED));

/// Greatest number of questions after a stop whether motors still move.
const QUESTIONS: u8 = 20;

impl DmcHost {
    /// Does what the session says, until it waits and no command can go on.
    pub(super) fn work(&mut self) {
        let mut bytes = vec![0; 1048];
        loop {
            match self.session.poll(self.clock, &self.table, &mut bytes) {
                Ok(Next::Transmit(bytes)) => self.out.push_back(sent(bytes)),
                Ok(Next::Event(event)) => {
                    debug!(?event);
                    let answer = match event {
                        host::Event::Ended { token, outcome: Outcome::Done(Some(message)) } => {
                            Some((Some(token), Answer::of(&message)))
                        }
                        host::Event::Unsolicited(_, message) => Some((None, Answer::of(&message))),
                        _ => None,
                    };
                    match (answer, event.to_static()) {
                        (Some((token, answer)), _) => self.answered(token, answer),
                        (None, Some(event)) => self.told(event),
                        (None, None) => {}
                    }
                }
                Ok(Next::Wait(until)) => {
                    self.until = until;
                    if !self.go_on() {
                        return;
                    }
                }
                Err(EncodeError::BufferTooSmall { needed, .. }) => bytes.resize(needed, 0),
                Err(error) => warn!(%error, "a request that cannot be sent"),
            }
        }
    }

    /// Gives a command of the host itself to the session. The session has room for it, because it is polled after each one.
    pub(super) fn tell(&mut self, command: impl FnOnce(&mut Session<STORE>) -> Result<(), NotTaken>) {
        if let Err(error) = command(&mut self.session) {
            warn!(%error, "a command is lost");
        }
    }

    /// Takes an event of the session.
    fn told(&mut self, event: host::Event<'static>) {
        let may_have_shutter_open = self.machine().may_have_shutter_open();
        match event {
            host::Event::Ended { token, outcome } => {
                let is_done = matches!(outcome, Outcome::Done(_));
                return self.ended(token, if is_done { Ok(Answer::Done) } else { Err(outcome) });
            }
            // This host sets the uses of a motor only before it moves it.
            host::Event::Greeted(_) => {
                self.uses.clear();
                self.limits.clear();
                // A device that was switched on has no move.
                self.is_uploaded &= self.machine().is_loaded() != Some(false);
                self.tell(|session| session.configured(OWN));
            }
            host::Event::LinkDown => self.rest = None,
            host::Event::HardStop(..) => {
                self.end_waiting(Outcome::Failed(Failure::HardStop));
                self.closes |= may_have_shutter_open;
                self.close_later();
            }
            host::Event::Ready { .. } => self.close_later(),
            host::Event::Stopped(target) => {
                // The machine itself sends a silent stop after a run or shot that failed.
                self.closes |= target == StopTarget::AllSilent && may_have_shutter_open;
                self.rest = Some((self.clock, QUESTIONS));
            }
            _ => {}
        }
        self.events.push_back(Event::Machine(event));
    }

    /// Takes an answer, or what the device tells by itself. Late answers are of no use, except positions and inputs.
    fn answered(&mut self, token: Option<Token>, answer: Answer) {
        if let Answer::Positions(positions) = &answer {
            self.positions = Some(positions.clone());
            self.events.push_back(Event::Positions(positions.clone()));
        }
        match (token, answer) {
            (Some(token), answer) => self.ended(token, Ok(answer)),
            (None, Answer::Inputs(inputs)) => self.events.push_back(Event::Inputs(inputs)),
            (None, _) => {}
        }
    }

    /// Takes the end of a command.
    fn ended(&mut self, token: Token, mut end: Result<Answer, Outcome<'static>>) {
        let asked = self.asked.remove(&token);
        let message = asked.as_ref().map(Owned::message);
        match message {
            // Some devices tell positions beside an acknowledgement.
            Some(HostMessage::MotorGetPosition(_)) if end == Ok(Answer::Done) => {
                end = Ok(self.positions.clone().map_or(Answer::Done, Answer::Positions));
            }
            Some(HostMessage::MotorConfigure(set)) => {
                // A device that does not know uses has all its motors in use.
                match end {
                    Ok(_) | Err(UNSUPPORTED) => self.uses.insert(set.motor, set.flags),
                    Err(_) => self.uses.remove(&set.motor),
                };
            }
            Some(HostMessage::MotorSetLimits(set)) if end.is_ok() => self.limits.set(&set),
            _ => {}
        }
        match (token, end) {
            (USES, Err(outcome)) if outcome != UNSUPPORTED => {
                if let Some(Waiting { token, .. }) = self.waiting.pop_front() {
                    self.ended(token, Err(outcome));
                }
            }
            (CHECK, end) => self.checked(end.is_ok()),
            (OWN, Err(Outcome::Refused(refusal))) => self.events.push_back(Event::Refused(refusal)),
            // Events tell what comes of a command without a token, and the machine keeps what the others are for.
            (OWN | SHUTTER | REST | USES, _) => {}
            (_, Ok(answer)) => {
                let check = message.as_ref().and_then(|message| Check::of(token, message));
                if check.is_some() && self.is_uploaded {
                    self.check = check;
                    return self.ask(CHECK, MotorGetPosition::default().into());
                }
                if let Some(HostMessage::RtUploadMoveBegin(_)) = message {
                    self.is_uploaded = true;
                }
                self.events.push_back(Event::Ended(token, Ok(answer)));
            }
            (_, Err(outcome)) => self.events.push_back(Event::Ended(token, Err(outcome))),
        }
    }

    /// Ends all commands that wait. Their messages were not sent.
    fn end_waiting(&mut self, outcome: Outcome<'static>) {
        for Waiting { token, .. } in std::mem::take(&mut self.waiting) {
            self.ended(token, Err(outcome));
        }
    }

    /// Sends the first command that waits, if its motors have their uses. Otherwise sets the uses of the next motor. Returns
    /// whether it did either.
    fn go_on(&mut self) -> bool {
        if self.asked.contains_key(&USES) {
            return false;
        }
        let Some(&Waiting { token, is_sequence }) = self.waiting.front() else { return false };
        let count = self.machine().device().map_or(0, |device| device.motor_count.min(32));
        let table = self.is_uploaded.then_some(&self.table);
        let message = self.asked.get(&token).map(Owned::message);
        if let Some((motor, flags)) = message.and_then(|message| lacking(&self.uses, &message, table, count)) {
            // The machine refuses it during a run, if the motor would take part in the run.
            self.ask(USES, MotorConfigure { motor, flags, tail: &[] }.into());
        } else {
            self.waiting.pop_front();
            self.send(token, is_sequence);
        }
        true
    }

    /// A way has ended, and the positions of its motors are known, or cannot be known.
    fn checked(&mut self, is_known: bool) {
        if let Some(check) = self.check.take() {
            let holds = is_known && check.holds(self.positions.as_ref(), &self.table);
            let end = if holds { Ok(Answer::Done) } else { Err(Outcome::NotConfirmed) };
            self.events.push_back(Event::Ended(check.token, end));
        }
    }

    /// Sends a request of the host itself.
    fn ask(&mut self, token: Token, message: HostMessage<'_>) {
        self.asked.extend(Owned::new(&message).map(|owned| (token, owned)));
        self.send(token, false);
    }

    /// Gives the message of a command to the session.
    fn send(&mut self, token: Token, is_sequence: bool) {
        let Some(message) = self.asked.get(&token).map(Owned::message) else { return };
        let session = &mut self.session;
        let sent = if is_sequence { session.sequence(token, message) } else { session.request(token, message) };
        if let Err(error) = sent {
            warn!(%error, "a command cannot be taken");
            self.ended(token, Err(Outcome::Refused(Refusal::Busy)));
        }
    }

    /// Closes the shutter within some seconds, if it is to be closed.
    fn close_later(&mut self) {
        if self.closes {
            self.rest = Some((self.clock, QUESTIONS));
        }
    }

    /// Closes the shutter, if a stop left it open.
    fn close_shutter(&mut self) {
        self.closes &= self.machine().may_have_shutter_open();
        if !self.closes || self.asked.contains_key(&SHUTTER) {
            return;
        }
        self.ask(SHUTTER, GioCam::default().into());
    }

    /// Takes bytes that arrived.
    pub(super) fn take(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            let taken = self.session.receive(self.clock, bytes);
            bytes = &bytes[taken..];
            self.work();
        }
    }

    /// Does what is due.
    pub(super) fn due(&mut self) {
        self.work();
        let Some((_, left)) = self.rest.take_if(|(due, _)| *due <= self.clock) else { return };
        self.close_shutter();
        self.closes &= left > 0;
        let may_move = self.session.may_move();
        if left > 0 && (may_move || self.closes) {
            let timeout = self.machine().options().request_timeout();
            self.rest = Some((self.clock.after(timeout.into()), left - 1));
            if may_move && !self.asked.contains_key(&REST) {
                self.ask(REST, MotorStatusRequest::default().into());
            }
        }
        self.work();
    }

    /// Carries out a command.
    pub(super) fn obey(&mut self, command: Command) {
        match command {
            Command::Greet => self.tell(|session| session.greet(OWN)),
            Command::Go => self.tell(|session| session.go(OWN)),
            Command::EndStops => {
                self.tell(|session| session.end_stops(OWN));
                self.close_later();
            }
            Command::Stop(target) => self.stop(target),
            Command::Ask(token, message) => match self.limits.within(message, self.positions.as_ref()) {
                Ok(message) => self.submit(token, &message, false),
                Err(code) => self.refuse(token, Refusal::WouldBeRefused(code)),
            },
            Command::Begin(token, message) => self.submit(token, &message, true),
            Command::Shoot(token, shot) => self.submit(token, &shot.message(), true),
            Command::Upload(token, table) => match self.fits(&table) {
                Ok(begin) if !self.is_busy(token, true) => {
                    (self.table, self.is_uploaded) = (table, false);
                    self.submit(token, &begin.into(), true);
                }
                Ok(_) => self.refuse(token, Refusal::Busy),
                Err(_) => self.refuse(token, Refusal::WouldBeRefused(AckCode::ERR_RANGE)),
            },
        }
        self.work();
    }

    fn stop(&mut self, target: StopTarget) {
        info!(?target, "stop");
        let was_open = self.machine().may_have_shutter_open();
        self.tell(|session| match target {
            StopTarget::Motor(motor) => session.stop_motor(OWN, motor),
            StopTarget::Virtual(motor) => session.stop_virtual(OWN, motor),
            _ => session.stop(OWN),
        });
        self.end_waiting(Outcome::Failed(Failure::Stopped));
        self.work();
        // A stop of one motor leaves a shutter open that a request opened.
        let is_all = matches!(target, StopTarget::All | StopTarget::AllSilent);
        self.closes |= self.machine().may_have_shutter_open() && (is_all || !was_open);
        self.close_shutter();
    }

    /// Whether a command cannot be taken: its token is in use, or a sequence, or the check at its end, runs.
    fn is_busy(&self, token: Token, is_sequence: bool) -> bool {
        let is_taken = token >= FIRST_OWN || self.asked.contains_key(&token);
        let waits = self.waiting.iter().any(|waiting| waiting.is_sequence);
        is_taken || (is_sequence && (waits || self.check.is_some() || self.machine().progress().is_some()))
    }

    fn submit(&mut self, token: Token, message: &HostMessage<'_>, is_sequence: bool) {
        // The request that closes the shutter after a stop could end a new photo.
        let is_closing = self.closes || self.asked.contains_key(&SHUTTER);
        if self.is_busy(token, is_sequence) || (is_closing && message.opens_shutter()) {
            return self.refuse(token, Refusal::Busy);
        }
        let Ok(owned) = Owned::new(message) else {
            return self.refuse(token, Refusal::WouldBeRefused(AckCode::ERR_RANGE));
        };
        self.asked.insert(token, owned);
        if message.conduct().may_move() {
            self.waiting.push_back(Waiting { token, is_sequence });
        } else {
            self.send(token, is_sequence);
        }
    }

    fn refuse(&mut self, token: Token, refusal: Refusal) {
        self.events.push_back(Event::Ended(token, Err(Outcome::Refused(refusal))));
    }
}

/// Bytes of a message, which is noted in the log.
fn sent(bytes: &[u8]) -> Outgoing {
    if enabled!(Level::DEBUG) {
        if let Ok(Ok(message)) = Frame::decode(bytes).map(|frame| HostMessage::decode(&frame)) {
            debug!("sends {message}");
        } else {
            debug!(len = bytes.len(), "sends zero bytes, which complete a frame that was cut off");
        }
    }
    Outgoing::Bytes(LINE, bytes.to_vec())
}
