"""Programs for those who work on AgentRob."""
