//! Moves: stored, made ready, played and followed to their end.

use std::path::Path;
use std::time::Duration;

use kos_proto::HostMessage;
use kos_proto::host::{self, Move as Told, MoveState, Outcome, Refusal};
use kos_proto::message::{ActionId, MotorAddress, Normalized, Photos, Seconds};
use kos_proto::trajectory::{Delay, LiveMotion, Loop, Play, Style, TimeLapseMotion, Trajectory};
use motion_move::Move;
use motion_rigs::kos_host::{Command as Order, Event, StoredMove};
use tokio::time::Instant;

use super::{Drive, ended, failed, is_done, not_reported, plan, time};
use crate::drive::Trouble;
use crate::drive::command::Shots;
use crate::drive::output::At;

/// Time that motors may take to the start of a move. Our client reports a delay after two minutes.
const HOME: Duration = Duration::from_mins(10);
/// Time between two lines about an upload.
const TELL: Duration = Duration::from_secs(1);
/// Report that a load waits for.
const READY: &str = "that the move is ready";
/// Greatest distance of a motor at rest from its target, as a part of its range.
const NEAR: f64 = 1e-3;

/// Result of a move.
enum End {
    /// The move was played to its end.
    Reached,
    /// The connection was lost, and the move was over when it was made again.
    Unseen,
}

impl Drive<'_> {
    /// Reads a file, and checks whether the rig can play its move.
    fn planned(&mut self, file: &Path, play: impl Fn(&Move) -> Result<Play, Trouble>) -> Result<StoredMove, Trouble> {
        let file = Move::read(file).map_err(|error| Trouble::Refused(error.to_string()))?;
        let stored = plan::stored(&file, play(&file)?)?;
        plan::check(&file, &stored, &self.motors())?;
        if let Some(note) = plan::left_out(&file) {
            self.print(format_args!("{note}"))?;
        }
        Ok(stored)
    }

    #[expect(clippy::cast_possible_truncation, reason = "the protocol has 32-bit numbers")]
    fn live(&mut self, file: &Path) -> Result<StoredMove, Trouble> {
        let home_speed = self.home_speed()?;
        self.planned(file, |file| {
            let duration = Seconds(file.duration() as f32);
            Ok(Play::Live(LiveMotion { duration, repeat: Loop::Once, delay: Delay::None, home_speed }))
        })
    }

    fn home_speed(&self) -> Result<Normalized, Trouble> {
        let part = self.options.home_speed;
        if part > 0.0 && part <= 1.0 {
            return Ok(Normalized(part));
        }
        Err(Trouble::Refused(format!("the home speed is {part}: give more than 0, and at most 1")))
    }

    pub(super) async fn upload(&mut self, file: &Path) -> Result<(), Trouble> {
        let stored = self.live(file)?;
        is_done(self.load(stored, true).await?, READY)?;
        self.print(format_args!("the move is stored and ready; the motors do not move until it is played"))
    }

    pub(super) async fn run(&mut self, file: &Path, reverse: bool) -> Result<(), Trouble> {
        let mut stored = self.live(file)?;
        if reverse {
            // A rig may ignore the direction of a start. So the move is mirrored.
            stored =
                stored.reversed().map_err(|why| Trouble::Refused(format!("the move cannot be reversed: {why}")))?;
        }
        self.play(stored).await
    }

    pub(super) async fn program(&mut self, file: &Path, shots: &Shots) -> Result<(), Trouble> {
        let home_speed = self.home_speed()?;
        let exposure = time(shots.exposure, 0.0)?;
        let interval = time(shots.interval - shots.exposure, 0.0).map_err(|_| {
            Trouble::Refused(format!(
                "an interval of {} s is too short for the exposure: give a longer one",
                shots.interval
            ))
        })?;
        if shots.shots == 0 || interval.0 + exposure.0 <= 0.0 {
            return Err(Trouble::Refused("give at least one photo, and an interval of more than 0 s".to_owned()));
        }
        let lapse = TimeLapseMotion {
            style: if shots.continuous { Style::Continuous } else { Style::ShootMoveShoot },
            interval,
            exposure,
            photos: shots.shots,
            photos_before: 0,
            photos_after: 0,
            delay: Delay::None,
            home_speed,
        };
        let stored = self.planned(file, |_| Ok(Play::TimeLapse(lapse)))?;
        self.play(stored).await?;
        self.print(format_args!("{} photos are taken", shots.shots))
    }

    /// Stores a move and makes it ready. Returns how that ended.
    async fn load(&mut self, stored: StoredMove, delay_return: bool) -> Result<Outcome<'static>, Trouble> {
        let (bytes, before) = (HostMessage::from(stored.data()).encoded_len(), self.session.written());
        let token = self.order(Order::Load { stored, delay_return });
        if !delay_return {
            self.print(format_args!("the motors go to where the move begins"))?;
        }
        let until = Instant::now() + HOME;
        while Instant::now() < until {
            if let Some(outcome) = self.look(TELL, |event| ended(event, token)).await? {
                return Ok(outcome);
            }
            self.uploads(bytes, self.session.written() - before)?;
        }
        Err(Trouble::Failed(not_reported(READY)))
    }

    /// Prints which part of an upload is written, until it is whole. Nearly all of its bytes are those of the move.
    #[expect(clippy::cast_precision_loss, reason = "a part that a person reads")]
    fn uploads(&mut self, bytes: usize, written: u64) -> Result<(), Trouble> {
        let part = written as f64 / bytes as f64;
        if part < 1.0 {
            self.progress(Some(part), Vec::new(), format_args!("the move is uploaded: {:.0} %", 100.0 * part))?;
        }
        Ok(())
    }

    async fn play(&mut self, stored: StoredMove) -> Result<(), Trouble> {
        match self.load(stored.clone(), false).await? {
            // The start of a move sends the motors to where it begins, too.
            Outcome::Refused(Refusal::Unsupported { action: Some(ActionId::SETUP_PLAYBACK), .. }) => {
                self.all_rest().await?;
                self.order(Order::PlayDirect { stored: stored.clone() });
            }
            outcome => {
                is_done(outcome, READY)?;
                self.command(host::Command::Play);
            }
        }
        match self.follow().await? {
            End::Reached => self.print(format_args!("the move is over")),
            End::Unseen => self.judge(&stored).await,
        }
    }

    /// Follows a move to its end, also after a lost connection.
    async fn follow(&mut self) -> Result<End, Trouble> {
        let (mut reached, mut lost) = (false, None::<Instant>);
        self.error = None;
        loop {
            let left = lost.map(|lost| self.options.patience.saturating_sub(lost.elapsed()));
            if left.is_some_and(|left| left.is_zero()) {
                let why = self.session.why().unwrap_or_else(|| "the rig is gone".to_owned());
                return Err(Trouble::Line(format!(
                    "{why}: the move may still run: watch the rig, and use its emergency stop if needed"
                )));
            }
            match self.next(left.unwrap_or(Duration::from_mins(1))).await? {
                Some(Event::Machine(host::Event::LinkDown(_))) => {
                    if lost.is_none() {
                        self.print(format_args!("the connection is lost: the move goes on, connecting again"))?;
                    }
                    lost = lost.or_else(|| Some(Instant::now()));
                }
                Some(Event::Machine(host::Event::Ready { .. })) if lost.is_some() => {
                    if !self.move_state().runs() {
                        return Ok(End::Unseen);
                    }
                    lost = None;
                    self.print(format_args!("the connection is made again, and the move still runs"))?;
                }
                Some(Event::Machine(host::Event::Move(told))) => match told {
                    Told::Running(_) | Told::Found(_) => {
                        reached = self.move_state() == MoveState::Ended;
                        self.how_far(None, None)?;
                    }
                    Told::Progress { elapsed, photos, .. } => {
                        self.how_far(Some(elapsed.0), photos.and_then(Photos::count))?;
                    }
                    Told::EndReached => reached = true,
                    Told::Failed(code) => return Err(failed(code, MotorAddress::ALL)),
                    Told::OtherWay => {
                        return Err(Trouble::Failed(
                            "the rig plays the move from its end to its begin: check the rig".to_owned(),
                        ));
                    }
                    Told::Finished { .. } if reached => return Ok(End::Reached),
                    Told::Finished { .. } => {
                        let stopped =
                            || Trouble::Failed("the move was stopped by something else: check the rig".to_owned());
                        return Err(self.error.map_or_else(stopped, |(code, motor)| failed(code, motor)));
                    }
                    _ => {}
                },
                _ => {}
            }
        }
    }

    /// Prints the part of the move that is played, and the positions of its motors.
    fn how_far(&mut self, part: Option<f32>, photos: Option<u32>) -> Result<(), Trouble> {
        let motors = self.motors();
        let places: Vec<String> = motors
            .iter()
            .map(|motor| format!("motor {} at {}", motor.motor_address, super::Shown(motor.position)))
            .collect();
        let positions = motors
            .iter()
            .map(|motor| At { motor: motor.motor_address.number(), position: motor.position.0.into() })
            .collect();
        let begin = part.map_or_else(|| "the move runs".to_owned(), |part| format!("{:.0} %", 100.0 * part));
        let photos = photos.filter(|photos| *photos > 0).map_or(String::new(), |photos| format!(", {photos} photos"));
        let line = format_args!("{begin}{photos}: {}", places.join(", "));
        self.progress(part.map(f64::from), positions, line)
    }

    /// Decides whether a move reached its end, if it was over before the connection was made again. Only the positions
    /// of the motors show that. The motors are stopped first, because only a confirmed stop shows that they rest.
    async fn judge(&mut self, stored: &StoredMove) -> Result<(), Trouble> {
        self.all_rest().await?;
        let data = stored.data();
        let tracks = Trajectory::new(&data).map_err(|error| Trouble::Failed(error.to_string()))?;
        let motors = self.motors();
        let all = tracks.tracks().all(|track| {
            let known = motors.iter().find(|known| known.motor_address.number() == track.motor().number());
            let range = known.and_then(|known| Some((known.relative_position()?, known.range()?)));
            let part = range.map(|(at, range)| f64::from(at.0) / f64::from(range.0));
            part.zip(track.at_elapsed(1.0)).is_some_and(|(is, should)| (is - should.position).abs() < NEAR)
        });
        if all {
            return self
                .print(format_args!("the move is over: its motors rest at its end, and were not observed on the way"));
        }
        Err(Trouble::Failed("the move did not reach its end while the connection was lost: check the rig".to_owned()))
    }
}
