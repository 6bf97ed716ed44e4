"""HTTP: the calls of the service, over `tilecast.jobs`. See `app.create_app` and `server.serve`."""
