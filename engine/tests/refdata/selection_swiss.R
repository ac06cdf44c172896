# Terms of a linear model for fertility in 47 Swiss provinces (R's data set swiss), by other programs.
# Run in this folder: Rscript selection_swiss.R > selection_swiss.json   (R 4.2, leaps 3.1, glmnet 4.1-6, jsonlite)
suppressMessages({ library(leaps); library(glmnet) })
x <- as.matrix(swiss[, -1])
y <- swiss$Fertility
m <- length(y)

# Backward elimination: the sets of columns, and the criteria of each fit. extractAIC's k counts no variance.
steps <- summary(regsubsets(x, y, method = "backward", nvmax = ncol(x)))
models <- lapply(ncol(x):0, function(size) {
  kept <- if (size > 0) which(steps$which[size, -1]) else integer(0)
  fit <- if (size > 0) lm(y ~ x[, kept]) else lm(y ~ 1)
  h <- hatvalues(fit)
  list(columns = I(as.integer(unname(kept))), rss = sum(resid(fit)^2), aic = AIC(fit), bic = BIC(fit),
       press = sum((resid(fit) / (1 - h))^2))
})
walked <- step(lm(Fertility ~ ., data = swiss), trace = 0, k = log(m))

# The elastic net, with folds of neighbouring rows: row i of 0 to 46 is in fold floor(10 i / 47). glmnet scales the
# heights to unit variance, and with them the ratio of both parts of the penalty; here that is undone.
net <- function(rows, lambda, alpha) {
  deviation <- sqrt(mean((y[rows] - mean(y[rows]))^2))
  share <- alpha / deviation + 1 - alpha
  fit <- glmnet(x[rows, ], y[rows] / deviation, alpha = min(1, alpha / deviation / share), lambda = lambda * share,
                thresh = 1e-24, maxit = 1e8)
  list(beta = as.matrix(fit$beta) * deviation, a0 = fit$a0 * deviation)
}
glmnet.control(fdev = 0, devmax = 1)
folds <- floor(10 * (seq_len(m) - 1) / m) + 1
unit <- scale(x) * sqrt(m / (m - 1))
nets <- lapply(c(1, 0.5), function(alpha) {
  largest <- max(abs(crossprod(unit, y - mean(y)))) / m / alpha
  # a trace above, so that rounding lets nothing in at the first
  lambda <- largest * (1 + 1e-10) * 1e-4^((0:99) / 99)
  error <- rowSums(sapply(1:10, function(fold) {
    own <- net(folds != fold, lambda, alpha)
    out <- which(folds == fold)
    colSums((y[out] - (x[out, , drop = FALSE] %*% own$beta + rep(own$a0, each = length(out))))^2)
  }))
  own <- net(rep(TRUE, m), lambda, alpha)
  list(alpha = alpha, lambda = lambda, error = unname(error),
       kept = lapply(seq_along(lambda), function(k) I(as.integer(which(own$beta[, k] != 0)))))
})
cat(jsonlite::toJSON(list(
  name = "selection_swiss",
  source = "selection_swiss.R on R's data set swiss (Mosteller and Tukey 1977)",
  x = unname(split(x, row(x))), y = y, names = colnames(x),
  backward = models, step_bic = sort(match(names(coef(walked))[-1], colnames(x))),
  folds = folds, nets = nets
), digits = NA, auto_unbox = TRUE), "\n", sep = "")
