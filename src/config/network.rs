//! Networks of addresses.

use std::net::IpAddr;

use ipnet::IpNet;

use super::bounds::parse_list;

/// Networks in CIDR notation; a single address is a network of its own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Networks(Vec<IpNet>);

impl Networks {
    /// True if `address` is in one of them. An IPv4 address that is written as one of IPv6 counts
    /// as what it is.
    pub fn contain(&self, address: IpAddr) -> bool {
        let address = address.to_canonical();
        self.0.iter().any(|network| network.contains(&address))
    }
}

/// Reads networks separated by commas; an empty text has none.
pub fn parse_networks(text: &str) -> Result<Networks, String> {
    let network = |text: &str| {
        let address = || text.parse::<IpAddr>().ok().map(IpNet::from);
        let refused = || format!("`{text}` is not a network; write ADDRESS/BITS, such as 10.1.0.0/16 or fd00::/8");
        text.parse().ok().or_else(address).ok_or_else(refused)
    };
    parse_list(text, network).map(Networks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_are_read_strictly() {
        let networks = parse_networks("10.1.0.0/16, 192.168.0.7,fd00::/8").unwrap();
        let is_in = |text: &str| networks.contain(text.parse().unwrap());
        assert!(is_in("10.1.255.1") && is_in("192.168.0.7") && is_in("fd00::1") && is_in("::ffff:10.1.0.1"));
        assert!(!is_in("10.2.0.1") && !is_in("192.168.0.8") && !is_in("fe80::1"));
        assert_eq!(parse_networks(" "), Ok(Networks::default()));
        for wrong in ["10.1.0.0/33", "10.1.0.0/16,", "proxy", "10.1/16"] {
            assert!(parse_networks(wrong).unwrap_err().contains("ADDRESS/BITS"), "{wrong}");
        }
    }
}
