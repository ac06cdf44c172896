//! Rate limits of callers, and of refusals of a peer.

use std::{
    hash::Hash,
    net::{IpAddr, Ipv6Addr},
    num::NonZeroU32,
};

use governor::{
    Quota, RateLimiter,
    clock::{Clock, DefaultClock},
    middleware::NoOpMiddleware,
    state::keyed::HashMapStateStore,
};

use super::prelude::*;
use crate::{
    config::ServeSettings,
    http::server::Peer,
    jobs::{Caller, Tenant},
};

type Limiter<K> = RateLimiter<K, HashMapStateStore<K>, DefaultClock, NoOpMiddleware>;

/// Refusals a minute for which a peer gets the reason.
const REFUSALS: NonZeroU32 = NonZeroU32::new(10).expect("is not 0");

/// Time after which those who did nothing are forgotten.
pub const FORGET: Duration = Duration::from_secs(60);

/// Who makes a request, as far as limits go.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Who {
    Caller(Tenant, Arc<str>),
    Network(IpAddr),
}

/// The limits, and how much of them is used up.
pub struct Rates {
    requests: Option<Limiter<Who>>,
    refusals: Limiter<IpAddr>,
}

impl Rates {
    pub fn new(settings: &ServeSettings) -> Self {
        let requests = settings.rate_limit.map(|limit| {
            let burst = settings.rate_burst.unwrap_or(limit);
            RateLimiter::hashmap(Quota::per_second(limit).allow_burst(burst))
        });
        Rates { requests, refusals: RateLimiter::hashmap(Quota::per_minute(REFUSALS)) }
    }

    /// Counts a request of this caller; where callers have no keys, of its peer.
    pub fn count(&self, caller: Option<&Caller>, peer: Option<Peer>) -> Result<(), Problem> {
        let Some(requests) = &self.requests else { return Ok(()) };
        let who = match (caller, peer) {
            (Some(caller), _) => Who::Caller(caller.tenant.clone(), caller.actor.clone()),
            (None, Some(Peer(peer))) => Who::Network(network(peer)),
            (None, None) => return Ok(()),
        };
        within(requests, &who).map_err(|wait| {
            telemetry::record_shed("rate_limit");
            too_many("This caller makes more requests than the server allows", wait)
        })
    }

    /// Counts a refusal of `problem`; a peer that has had too many hears that instead.
    pub fn refuse(&self, problem: Problem, peer: Option<Peer>) -> Problem {
        let Some(Peer(peer)) = peer else { return problem };
        match within(&self.refusals, &network(peer)) {
            Ok(()) => problem,
            Err(wait) => {
                telemetry::record_shed("refusals");
                too_many("Too many requests without a valid API key came from this address", wait)
            }
        }
    }

    /// Forgets those who would be allowed everything again.
    pub fn forget_idle(&self) {
        self.requests.iter().for_each(RateLimiter::retain_recent);
        self.refusals.retain_recent();
    }
}

/// The time to wait where `who` has used up its limit.
fn within<K: Hash + Eq + Clone>(limiter: &Limiter<K>, who: &K) -> Result<(), Duration> {
    limiter.check_key(who).map_err(|until| until.wait_time_from(limiter.clock().now()))
}

fn too_many(what: &str, wait: Duration) -> Problem {
    let seconds = (wait.as_secs_f64().ceil() as u32).max(1);
    Problem::new(ProblemCode::TooManyRequests, format!("{what}; try again after {seconds} s.")).retry_after(seconds)
}

/// Somebody with addresses of IPv6 has 2⁶⁴ of them.
fn network(peer: IpAddr) -> IpAddr {
    match peer {
        IpAddr::V4(_) => peer,
        IpAddr::V6(address) => Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peer(text: &str) -> Option<Peer> {
        Some(Peer(text.parse().unwrap()))
    }

    #[test]
    fn a_peer_gets_ten_refusals_before_429() {
        let rates = Rates::new(&ServeSettings::default());
        let status = |text: &str| rates.refuse(Problem::new(ProblemCode::Unauthorized, "no key"), peer(text)).status;
        let statuses: Vec<u16> = (0..12).map(|k| status(&format!("2001:db8::{k}"))).collect();
        assert_eq!(statuses, [[401; 10].as_slice(), &[429; 2]].concat());
        assert_eq!(status("2001:db8:0:1::1"), 401);
        rates.forget_idle();
        assert_eq!(status("2001:db8::1"), 429);
    }
}
