//! Memory of the past that the rules need.

use dmc_proto::host::{Contents, Effect, Event, HostMachine, Outcome, Source, State, StopTarget, Transmit};
use dmc_proto::message::{Ack, AckCode, DeviceMessage, HostMessage, RtGo};
use dmc_proto::{MessageId, Token};

/// Breach of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// A stop was not sent in the step of its request, as the first message of all.
    StopWaits,
    /// A stop was not obeyed in the step of its arrival, or was not acknowledged.
    StopIgnored,
    /// A stop was reported as obeyed, while a motor that it stops moves, or may begin to move at a signal of the
    /// operator.
    NotStopped,
    /// A stop was sent four times, and this was not reported.
    StopUntold,
    /// A request that must not be repeated was sent again, or another request too often.
    Repeats,
    /// A request was sent that a stop, a hard stop or a reset had called off.
    CalledOff,
    /// Two coordinated moves, or one of them and a move of a single motor, were active at once.
    MovesTwice,
    /// Two motion requests were unanswered at once.
    AsksTwice,
    /// A token ended twice, or was never open.
    EndsTwice,
}

/// Memory of the past.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(super) struct Book {
    /// Tokens that have not ended: bit n for token n.
    pub(super) open: u16,
    /// Tokens whose requests are done.
    pub(super) done: u16,
    /// Tokens whose requests must not move anything any more.
    called_off: u16,
    /// Token of the last sequence.
    sequence: u32,
    /// Number of times that the message of each token was sent.
    sent: [u8; 12],
    /// Number of times that the way to the first frame was sent.
    ways: u8,
    /// Number of times that GO may still be sent.
    signals: u8,
    /// Number of times that GO may still be refused and sent again.
    refusals: u8,
    /// Stops, the number of times that each was sent since its last request, and whether it was reported as not
    /// confirmed.
    stops: Vec<(StopTarget, u8, bool)>,
    /// Whether a stop was confirmed, and whether one was reported as not confirmed.
    pub(super) stopped: bool,
    pub(super) unconfirmed: bool,
    /// Whether the device was reset and the host does not know.
    pub(super) unheard_boot: bool,
    /// Whether the application has reported that the device is configured.
    pub(super) configured: bool,
    pub(super) fault: Option<Fault>,
}

/// Whether the effect is a stop that is sent.
pub(super) const fn is_stop(effect: &Effect<'_>) -> bool {
    matches!(effect, Effect::Transmit(Transmit { contents: Contents::Stop(_), .. }))
}

impl Book {
    pub(super) fn blame(&mut self, fault: Fault, is_so: bool) {
        if is_so {
            self.fault = self.fault.or(Some(fault));
        }
    }

    /// Calls off all earlier requests: they must not move anything any more.
    fn call_off(&mut self) {
        (self.called_off, self.signals, self.refusals) = (u16::MAX, 0, 0);
    }

    /// The application gives a command.
    pub(super) fn wants(&mut self, Token(token): Token, is_sequence: bool) {
        self.open |= 1 << token;
        self.called_off &= !(1 << token);
        if is_sequence {
            (self.sequence, self.ways) = (token, 0);
        }
    }

    /// The application gives the signal.
    pub(super) fn signal(&mut self) {
        (self.signals, self.refusals) = (1, 3);
    }

    /// The application requests a stop, which calls off its earlier requests.
    pub(super) fn wants_stop(&mut self) {
        self.call_off();
        self.stops.clear();
    }

    /// The host has made the step of a requested stop.
    pub(super) fn stop_wanted(&mut self, host: &HostMachine, effects: &[Effect<'_>]) {
        let is_sent = match (effects.first(), host.state()) {
            (Some(Effect::Event(event)), State::Offline) => matches!(event, Event::StopNotConfirmed(_)),
            (first, _) => first.is_some_and(is_stop),
        };
        self.blame(Fault::StopWaits, !is_sent);
    }

    /// A message reaches the host.
    pub(super) fn received(&mut self, host: &HostMachine, id: MessageId, message: &DeviceMessage<'_>) {
        match message {
            DeviceMessage::Ack(Ack { of, response_code: Some(AckCode::ERR_NOT_IN_POSITION), .. })
                if *of == go().kind() && host.pending().any(|pending| pending == (id, *of)) && self.refusals > 0 =>
            {
                self.signals += 1;
                self.refusals -= 1;
            }
            DeviceMessage::MotorHardStop(_) => self.call_off(),
            DeviceMessage::Hi(_) if id == MessageId::UNSOLICITED => self.unheard_boot = false,
            _ => {}
        }
    }

    /// The host reports an event.
    pub(super) fn event(&mut self, event: Event<'_>) {
        match event {
            Event::Ended { token: Token(token), outcome } => {
                let bit = 1 << token;
                self.blame(Fault::EndsTwice, self.open & bit == 0);
                self.open &= !bit;
                if let Outcome::Done(_) = outcome {
                    self.done |= bit;
                }
            }
            Event::StopNotConfirmed(stop) => {
                self.unconfirmed = true;
                self.stops.retain(|known| known.0 != stop);
                self.stops.push((stop, 0, true));
            }
            Event::Stopped(stop) => {
                self.stopped = true;
                self.stops.retain(|known| known.0 != stop);
            }
            Event::DeviceReset | Event::LinkDown => self.call_off(),
            Event::Greeted(_) => self.configured = false,
            _ => {}
        }
    }

    /// The host sends a message.
    pub(super) fn sent(&mut self, host: &HostMachine, contents: Contents, message: &HostMessage<'_>) {
        match contents {
            Contents::Stop(stop) => {
                if !self.stops.iter().any(|known| known.0 == stop) {
                    self.stops.push((stop, 0, false));
                }
                for known in self.stops.iter_mut().filter(|known| known.0 == stop) {
                    known.1 = known.1.saturating_add(1).min(4);
                }
            }
            Contents::Go => {
                self.blame(Fault::Repeats, self.signals == 0);
                self.signals = self.signals.saturating_sub(1);
            }
            Contents::ToFrame(_) => {
                self.ways += 1;
                self.blame(Fault::Repeats, self.ways > 3);
                self.blame(Fault::CalledOff, self.called_off & (1 << self.sequence) != 0);
            }
            Contents::Application(Source::Command(Token(token))) => {
                let conduct = message.conduct();
                if let Some(times) = self.sent.get_mut(token as usize) {
                    *times += 1;
                    let is_often = *times > if conduct.repeatable { 3 } else { 1 };
                    self.blame(Fault::Repeats, is_often);
                }
                self.blame(Fault::CalledOff, conduct.may_move() && self.called_off & (1 << token) != 0);
            }
            _ => {}
        }
        let asked = host.pending().filter(|(_, kind)| motions().any(|message| message.kind() == *kind));
        self.blame(Fault::AsksTwice, asked.count() > 1);
    }

    /// All effects of a step of the host are carried out.
    pub(super) fn step_ends(&mut self) {
        let is_untold = self.stops.iter().any(|&(_, times, told)| times > 3 && !told);
        self.blame(Fault::StopUntold, is_untold);
    }

    /// Whether all unconfirmed stops were reported.
    pub(super) fn tells(&self, stops: impl Iterator<Item = StopTarget>) -> bool {
        let is_told = |stop| self.stops.iter().any(|known| known.0 == stop && known.2);
        stops.into_iter().all(is_told)
    }
}

fn go() -> HostMessage<'static> {
    RtGo::default().into()
}

/// One message of each type of motion that a model uses.
fn motions() -> impl Iterator<Item = HostMessage<'static>> + Clone {
    use super::wants::Want;
    let wants = [Want::Move(1), Want::Jog(1), Want::ToFrame, Want::JogAll, Want::Run(Default::default()), Want::Shoot];
    wants.into_iter().filter_map(Want::message).chain([go()])
}
