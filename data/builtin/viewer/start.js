/* Starts the page: a live one has start_live. */
(typeof start_live === "function" ? start_live : start_still)().catch(error => {
  show_message(`This browser cannot compute the picture (${error.message}). Browsers of 2023 and later can.`);
  throw error;
});
