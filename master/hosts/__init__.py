"""Other people's tools: is this machine ready, how a host is started, what an FMU must give, systems as SSP archives."""
