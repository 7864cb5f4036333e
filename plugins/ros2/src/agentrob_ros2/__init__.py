"""ROS 2 bases for AgentRob, over Cyclone DDS, without a ROS installation."""
