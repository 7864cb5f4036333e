"""A Discourse to try things on: the part of its API that AgentRob uses, stateful, on loopback, without Ruby."""
