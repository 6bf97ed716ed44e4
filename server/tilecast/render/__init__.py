"""From a compiled scene to an image: plan, dispatch, film, error estimate, image files.

Command line and server use the same parts; `local` puts them together on a thread pool.
"""
