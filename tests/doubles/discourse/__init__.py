"""A stateful test double of Discourse: the part of its API that AgentRob uses, on loopback, without Ruby."""
