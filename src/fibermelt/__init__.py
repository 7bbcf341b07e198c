"""fibermelt: where a short-fiber polymer bead will void."""
