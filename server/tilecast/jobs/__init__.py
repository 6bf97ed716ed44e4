"""Jobs: what the service does with scenes, apart from HTTP. See `manager.Manager`."""
