//! What the device does and says when it is asked.

use rumbo_core::time::Time;

use super::{Emulator, Output, scanner};
use crate::lms200::protocol::{
    Command, FACTORY_PASSWORD, IndexRange, Measured, Mode, Reply, StatusReport, Variant,
};

/// Type of the device, as long as a real one's.
pub(super) const TYPE: &str = "LMS200;301063;V02.30 ";

impl Emulator {
    pub(super) fn obey(&mut self, now: Time, command: Command) {
        let is_on_request = self.output == Output::OnRequest && !self.is_installing;
        let reply = match command {
            Command::Reset => {
                self.say(now, Reply::ResetBegins);
                self.wake();
                Reply::PowerOn(TYPE.to_owned())
            }
            Command::Switch(Mode::Speed(speed)) => {
                // The answer still comes at the old speed.
                self.say(now, Reply::ModeSwitched(0));
                self.speed = speed;
                return;
            }
            Command::Switch(mode) => self.switch(now, mode),
            Command::OneScan if is_on_request => self.scan(None, now),
            Command::Part(part) if is_on_request => self.part(part, now),
            Command::Mean(n_scans) if is_on_request => Reply::Mean(n_scans, self.mean(n_scans, now)),
            Command::Status => Reply::Status(self.report()),
            Command::Errors => Reply::Errors(Vec::new()),
            Command::Hours => Reply::Hours(vec![0; 4]),
            Command::Type => Reply::Type(TYPE.to_owned()),
            Command::Variant(variant) => self.change_variant(variant),
            Command::KeepSpeed(_) => Reply::SpeedKept(0),
            Command::ReadConfiguration => Reply::Configuration(self.configuration.clone()),
            Command::WriteConfiguration(configuration) if self.is_installing => {
                let is_accepted = configuration.bytes().len() == self.configuration.bytes().len()
                    && configuration.unit().is_some()
                    && configuration.measuring_mode().is_some();
                if is_accepted {
                    self.configuration = configuration;
                }
                Reply::ConfigurationWritten(is_accepted, self.configuration.clone())
            }
            _ => Reply::NotAccepted,
        };
        self.say(now, reply);
    }

    fn switch(&mut self, now: Time, mode: Mode) -> Reply {
        let output = match mode {
            Mode::Installation(password) if password != FACTORY_PASSWORD => return Reply::ModeSwitched(1),
            Mode::Installation(_) | Mode::Diagnosis | Mode::OnRequest => Output::OnRequest,
            Mode::Continuous => Output::All,
            Mode::Means(n_scans) => Output::Means(n_scans.max(1)),
            Mode::Part(part) => Output::Part(part),
            Mode::MeansOfPart(n_scans, part) => Output::MeansOfPart(n_scans.max(1), part),
            Mode::Partials => Output::Partials,
            _ => return Reply::NotAccepted,
        };
        self.is_installing = matches!(mode, Mode::Installation(_));
        self.mode_code = mode.code();
        self.output = output;
        self.last_sent = 0;
        self.streaming_since = now;
        Reply::ModeSwitched(0)
    }

    fn change_variant(&mut self, variant: Variant) -> Reply {
        let is_offered = Variant::OFFERED.contains(&variant);
        if is_offered {
            self.variant = variant;
            self.output = Output::OnRequest;
        }
        Reply::Variant(is_offered, self.variant)
    }

    /// What continuous output says about a scan.
    pub(super) fn output_at(&mut self, at: Time) -> Reply {
        match self.output {
            Output::Partials => self.scan(Some((self.last_sent.wrapping_sub(1) % 4) as u8), at),
            Output::Part(part) => self.part(part, at),
            Output::Means(n_scans) => Reply::Mean(n_scans, self.mean(n_scans, at)),
            Output::MeansOfPart(n_scans, part) => {
                let measured = within(part, self.mean(n_scans, at));
                Reply::MeanOfPart(n_scans, part, measured)
            }
            Output::All | Output::OnRequest => self.scan(None, at),
        }
    }

    fn scan(&mut self, partial: Option<u8>, at: Time) -> Reply {
        let words = self.scanner.words(self.variant, partial, &self.configuration, at);
        Reply::Scan(self.measured(partial, words))
    }

    fn part(&mut self, part: IndexRange, at: Time) -> Reply {
        let words = self.scanner.words(self.variant, None, &self.configuration, at);
        Reply::Part(part, within(part, self.measured(None, words)))
    }

    fn mean(&mut self, n_scans: u8, at: Time) -> Measured {
        let words = self.scanner.mean_words(self.variant, n_scans, &self.configuration, at);
        self.measured(None, words)
    }

    fn measured(&self, partial: Option<u8>, words: Vec<u16>) -> Measured {
        Measured { unit: scanner::units(&self.configuration).0, partial, words, indices: None }
    }

    fn report(&self) -> StatusReport {
        let mut report = StatusReport::of_bytes(&[0; 152]);
        let block = self.configuration.bytes();
        let setting = |place: usize| block.get(place).copied().unwrap_or(0);
        report.put(1, b"V02.30 ");
        report.put(8, &[self.mode_code]);
        report.put(10, b"EMULATOR");
        report.put(102, &[setting(5)]);
        report.put(107, &self.variant.field_deg.to_le_bytes());
        report.put(109, &self.variant.resolution_centideg.to_le_bytes());
        report.put(111, &[setting(10)]);
        report.put_speed(self.speed);
        report.put(118, &[1]);
        report.put(122, &[setting(6)]);
        report.put(124, b"V03.04 ");
        report
    }
}

fn within(part: IndexRange, measured: Measured) -> Measured {
    let n = usize::from(part.last.saturating_sub(part.first)) + usize::from(part.last >= part.first);
    let words = measured.words.into_iter().skip(usize::from(part.first.max(1)) - 1).take(n).collect();
    Measured { words, ..measured }
}
