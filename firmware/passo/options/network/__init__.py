"""Links over a network: Wi-Fi, the page, a broker."""
