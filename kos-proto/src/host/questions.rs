//! Questions to the device: who asked, what waits for the answer, and the question after a stop.

use motion_core::time::Millis;

use super::Output;
use super::event::{Event, Failure, LinkDownReason, Outcome};
use super::input::Get;
use super::machine::{HostMachine, State};
use super::requests::{Asker, Fence};
use super::transmit::Transmit;
use crate::DeviceMessage;

impl HostMachine {
    /// Number of questions what a device is, before it is given up.
    const QUESTIONS: u8 = 3;

    /// Asks the device something; `false` if that is asked already.
    pub(super) fn ask(&mut self, now: Millis, output: &mut Output<'_>, get: Get, asker: Asker) -> bool {
        let asks = self.requests.ask(get, asker, now.after(self.options.request_timeout()));
        if asks {
            output.transmit(Transmit::Get(get));
            if get == Get::DeviceInfo {
                self.owed = self.owed.saturating_add(1);
            }
            if get == Get::MotorInfo {
                self.motors.begin_series();
            }
        }
        asks
    }

    /// Gives the next part of an answer the full time.
    pub(super) fn more(&mut self, now: Millis, get: Get) {
        self.requests.go_on(get, now.after(self.options.request_timeout()));
    }

    /// Ends a question with its answer; `false` if it was not asked.
    pub(super) fn answered<'a>(
        &mut self,
        now: Millis,
        output: &mut Output<'a>,
        get: Get,
        message: DeviceMessage<'a>,
    ) -> bool {
        self.pay(get);
        // A late answer belongs to an earlier question, not to the one after the stop.
        let late = get == Get::DeviceInfo && matches!(self.fence, Fence::Up(_)) && self.is_owed();
        match if late { None } else { self.requests.end(get) } {
            None => {
                output.event(Event::Unsolicited(message));
                if let (Fence::Stale(_), false) = (self.fence, self.is_owed()) {
                    self.fence = Fence::Down;
                }
                return false;
            }
            Some(Asker::Application(token)) => output.event(Event::ended(token, Outcome::Done(Some(message)))),
            Some(Asker::Machine) => {}
        }
        self.passed(now, output, get);
        true
    }

    /// Ends a question without an answer. What waits for it goes on without.
    pub(super) fn failed(&mut self, now: Millis, output: &mut Output<'_>, get: Get, why: Failure) {
        if matches!(why, Failure::Unsupported | Failure::Malformed) {
            self.pay(get);
        }
        match self.requests.end(get) {
            None => return,
            Some(Asker::Application(token)) => output.event(Event::ended(token, Outcome::Failed(why))),
            Some(Asker::Machine) => {}
        }
        match (self.state, get) {
            (State::AwaitDeviceInfo, Get::DeviceInfo) if self.tries < Self::QUESTIONS => {
                self.tries = self.tries.saturating_add(1);
                self.ask(now, output, get, Asker::Machine);
            }
            (State::AwaitDeviceInfo, Get::DeviceInfo) => return self.close(now, output, LinkDownReason::NoAnswer),
            (State::AwaitMotorInfo, Get::MotorInfo) => self.lock(output, false),
            (State::AwaitGuid, Get::DeviceGuid) => self.has_guid(now, output, None),
            (State::AwaitSoftware, Get::SoftwareId) => self.has_platform(output, None),
            _ => {}
        }
        self.passed(now, output, get);
    }

    /// Counts an answer, whatever it says.
    fn pay(&mut self, get: Get) {
        if get == Get::DeviceInfo {
            self.owed = self.owed.saturating_sub(1);
        }
    }

    /// Whether an answer is still under way, as far as that can be known: over USB it may be lost.
    fn is_owed(&self) -> bool {
        self.is_tcp() && self.owed > 0
    }

    /// Ends a question after a stop. If the last stop was sent after it, or it is not answered, another one is asked.
    fn passed(&mut self, now: Millis, output: &mut Output<'_>, get: Get) {
        if get != Get::DeviceInfo {
            return;
        }
        self.fence = match self.fence {
            Fence::Late => self.fence_again(now, output, 0),
            Fence::Up(tries) if self.is_owed() && tries < Self::QUESTIONS => self.fence_again(now, output, tries),
            Fence::Up(_) if self.is_owed() => Fence::Stale(now.after(1)),
            Fence::Stale(at) if self.is_owed() => Fence::Stale(at),
            Fence::Down | Fence::Up(_) | Fence::Stale(_) => Fence::Down,
        };
    }

    fn fence_again(&mut self, now: Millis, output: &mut Output<'_>, tries: u8) -> Fence {
        self.ask(now, output, Get::DeviceInfo, Asker::Machine);
        Fence::Up(tries.saturating_add(1))
    }

    /// Asks after a stop, so that its confirmation can be told from one that comes late.
    pub(super) fn raise_fence(&mut self, now: Millis, output: &mut Output<'_>) {
        self.fence = if self.ask(now, output, Get::DeviceInfo, Asker::Machine) { Fence::Up(1) } else { Fence::Late };
    }

    /// Time at which the connection is given up because of what may come late.
    pub(super) const fn stale(&self) -> Option<Millis> {
        if let Fence::Stale(at) = self.fence { Some(at) } else { None }
    }
}
